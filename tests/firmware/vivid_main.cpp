// SPDX-License-Identifier: Apache-2.0
// The kernel's virtual video driver as a depth camera: plays a depth folder as Y16 into its output node, whence the
// driver carries it to its capture node; and sets controls by name, for the faults it offers.
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "hal/folder/depth_folder.h"
#include "tests/devices/words.h"

namespace im2fit {
namespace {

constexpr const char* kUsage =
    "usage: im2fit-vivid play CAPTURE_NODE OUTPUT_NODE DEPTH_FOLDER   until SIGTERM\n"
    "       im2fit-vivid set NODE NAME=VALUE...                       controls by name";

class Node {
 public:
  explicit Node(const std::string& path) : path_(path), file_(::open(path.c_str(), O_RDWR | O_CLOEXEC)) {}
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  ~Node() {
    if (file_ >= 0) ::close(file_);
  }
  int file() const { return file_; }
  template <class T>
  Status ask(unsigned long request, T& argument, const char* what) {
    while (::ioctl(file_, request, &argument) != 0)
      if (errno != EINTR) return Error{ErrorCode::io, path_ + ": " + what + ": " + std::strerror(errno)};
    return Ok{};
  }

 private:
  std::string path_;
  int file_;
};

Status set_control(Node& node, const std::string& name, int value) {
  v4l2_queryctrl entry{};
  for (;;) {
    entry.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    if (auto ok = node.ask(VIDIOC_QUERYCTRL, entry, ("no control " + name).c_str()); !ok) return ok;
    if (name == reinterpret_cast<const char*>(entry.name)) break;
  }
  // By the extended call: the plain one knows neither classes nor buttons of drivers.
  v4l2_ext_control control{};
  control.id = entry.id;
  control.value = value;
  v4l2_ext_controls controls{};
  controls.count = 1;
  controls.controls = &control;
  return node.ask(VIDIOC_S_EXT_CTRLS, controls, ("setting " + name).c_str());
}

// 640x480p59: the first of CEA-861's timings.
Status set_timings(Node& node) {
  v4l2_enum_dv_timings entry{};
  if (auto ok = node.ask(VIDIOC_ENUM_DV_TIMINGS, entry, "listing timings"); !ok) return ok;
  return node.ask(VIDIOC_S_DV_TIMINGS, entry.timings, "setting timings");
}

std::atomic<bool> ending{false};

class Player {
 public:
  Player(Node& node, std::unique_ptr<hal::FolderSource> clip) : node_(node), clip_(std::move(clip)) {}

  Status run() {
    if (auto ok = load(); !ok) return ok;
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = 640;
    format.fmt.pix.height = 480;
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_Y16;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    if (auto ok = node_.ask(VIDIOC_S_FMT, format, "setting Y16"); !ok) return ok;
    if (format.fmt.pix.pixelformat != V4L2_PIX_FMT_Y16 || format.fmt.pix.bytesperline != 1280)
      return Error{ErrorCode::unsupported, "the output node takes no Y16 of 640x480"};
    v4l2_requestbuffers request{};
    request.count = 4;
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.memory = V4L2_MEMORY_MMAP;
    if (auto ok = node_.ask(VIDIOC_REQBUFS, request, "asking for buffers"); !ok) return ok;
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer{};
      buffer.index = i;
      buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
      buffer.memory = V4L2_MEMORY_MMAP;
      if (auto ok = node_.ask(VIDIOC_QUERYBUF, buffer, "asking for a buffer"); !ok) return ok;
      void* address =
          ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, node_.file(), buffer.m.offset);
      if (address == MAP_FAILED) return Error{ErrorCode::io, "the output node's buffers cannot be mapped"};
      memory_.push_back(address);
      if (auto ok = queue(buffer); !ok) return ok;
    }
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    if (auto ok = node_.ask(VIDIOC_STREAMON, type, "starting"); !ok) return ok;
    std::puts("vivid playing");
    std::fflush(stdout);
    while (!ending) {
      pollfd wanted{node_.file(), POLLOUT, 0};
      if (::poll(&wanted, 1, 100) <= 0) continue;
      v4l2_buffer buffer{};
      buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
      buffer.memory = V4L2_MEMORY_MMAP;
      if (auto ok = node_.ask(VIDIOC_DQBUF, buffer, "taking a buffer"); !ok) return ok;
      if (auto ok = queue(buffer); !ok) return ok;
    }
    return Ok{};
  }

 private:
  Status load() {
    if (clip_->info().intrinsics.width != 640 || clip_->info().intrinsics.height != 480)
      return Error{ErrorCode::invalid_argument, "expected a folder of 640x480 pictures"};
    for (;;) {
      std::vector<std::uint16_t> pixels(640 * 480);
      const auto frame = clip_->next({pixels.data(), 640, 480}, 0);
      if (!frame && frame.error().code == ErrorCode::end_of_stream) return Ok{};
      if (!frame) return frame.error();
      frames_.push_back(std::move(pixels));
    }
  }
  Status queue(v4l2_buffer& buffer) {
    std::memcpy(memory_[buffer.index], frames_[next_++ % frames_.size()].data(), 640 * 480 * 2);
    buffer.bytesused = 640 * 480 * 2;
    buffer.field = V4L2_FIELD_NONE;
    return node_.ask(VIDIOC_QBUF, buffer, "handing over a buffer");
  }

  Node& node_;
  std::unique_ptr<hal::FolderSource> clip_;
  std::vector<std::vector<std::uint16_t>> frames_;
  std::vector<void*> memory_;
  std::size_t next_ = 0;
};

Status play(const std::vector<std::string>& words) {
  Node capture(words[1]);
  Node output(words[2]);
  if (capture.file() < 0 || output.file() < 0) return Error{ErrorCode::not_found, "the nodes cannot be opened"};
  if (auto ok = set_timings(capture); !ok) return ok;
  if (auto ok = set_timings(output); !ok) return ok;
  if (auto ok = set_control(capture, "Loop Video", 1); !ok) return ok;
  if (auto ok = set_control(capture, "OSD Text Mode", 2); !ok) return ok;
  auto clip = hal::FolderSource::open(words[3], {0, ""});
  if (!clip) return clip.error();
  if (auto ok = (*clip)->start(); !ok) return ok;
  return Player(output, std::move(*clip)).run();
}

Status set(const std::vector<std::string>& words) {
  Node node(words[1]);
  if (node.file() < 0) return Error{ErrorCode::not_found, words[1] + " cannot be opened"};
  for (std::size_t i = 2; i < words.size(); ++i) {
    const std::size_t equals = words[i].find('=');
    if (equals == std::string::npos) return Error{ErrorCode::invalid_argument, kUsage};
    const int value = static_cast<int>(std::strtol(words[i].c_str() + equals + 1, nullptr, 0));
    if (auto ok = set_control(node, words[i].substr(0, equals), value); !ok) return ok;
  }
  return Ok{};
}

}  // namespace
}  // namespace im2fit

int main(int argc, char** argv) {
  using namespace im2fit;
  const devices::Words words(argc, argv, {}, kUsage);
  const auto& given = words.words();
  ::signal(SIGTERM, [](int) { ending = true; });
  Status done = Error{ErrorCode::invalid_argument, kUsage};
  if (given.size() == 4 && given[0] == "play") done = play(given);
  if (given.size() >= 3 && given[0] == "set") done = set(given);
  if (done) return 0;
  std::fprintf(stderr, "im2fit-vivid: %s\n", done.error().message.c_str());
  return 1;
}
