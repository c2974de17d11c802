// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/v4l2_nodes.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include "hal/v4l2/v4l2_source.h"

namespace im2fit::hal {
namespace {

constexpr const char* kPrefix = "video";

// The numbers behind /dev/video, ascending.
std::vector<int> node_numbers() {
  std::vector<int> numbers;
  std::error_code code;
  for (std::filesystem::directory_iterator i("/dev", code), end; !code && i != end; i.increment(code)) {
    const std::string name = i->path().filename().string();
    if (name.rfind(kPrefix, 0) != 0) continue;
    int number = -1;
    const char* begin = name.data() + 5;
    const char* past = name.data() + name.size();
    if (const auto read = std::from_chars(begin, past, number); read.ec == std::errc() && read.ptr == past)
      numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

struct Nodes {
  std::vector<V4l2Device> depth;
  std::string closed;  // why the first node that does not open does not
};

Nodes look() {
  Nodes nodes;
  for (const int number : node_numbers()) {
    const std::string path = std::string("/dev/") + kPrefix + std::to_string(number);
    const auto device = open_video_device(path);
    if (!device) {
      if (nodes.closed.empty()) nodes.closed = device.error().message;
      continue;
    }
    const auto camera = describe_camera(**device, path);
    if (camera && camera->is_depth()) nodes.depth.push_back({path, camera->name, v4l2_serial(path)});
  }
  return nodes;
}

}  // namespace

std::string v4l2_serial(const std::string& path) {
  // "device" is the USB interface; its parent, the device, has the number.
  const std::string node = std::filesystem::path(path).filename().string();
  std::error_code code;
  const auto device = std::filesystem::canonical("/sys/class/video4linux/" + node + "/device", code);
  if (code) return "";
  std::ifstream file(device.parent_path() / "serial");
  std::string serial;
  std::getline(file, serial);
  return serial;
}

std::vector<V4l2Device> list_v4l2_devices() {
  return look().depth;
}

Result<std::string> find_v4l2_node(const std::string& path, const std::string& serial) {
  const Nodes nodes = look();
  std::string there;
  // The first: one camera may have several depth nodes, and twins may share a number.
  for (const V4l2Device& device : nodes.depth) {
    if ((path.empty() || device.path == path) && (serial.empty() || device.serial == serial)) return device.path;
    there += (there.empty() ? "" : ", ") + device.path + (device.serial.empty() ? "" : " (" + device.serial + ")");
  }
  return Error{ErrorCode::no_device,
               "no V4L2 depth camera" + (serial.empty() ? std::string() : " with serial " + serial) +
                   (path.empty() ? std::string() : " at " + path) + "; there " +
                   (there.empty() ? std::string("is none that offers Z16 or INZI") : "is " + there) +
                   (nodes.closed.empty() ? "" : " (" + nodes.closed + ")")};
}

}  // namespace im2fit::hal
