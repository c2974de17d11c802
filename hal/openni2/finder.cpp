// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/finder.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "hal/frame_path.h"

namespace im2fit::hal {
namespace {

constexpr std::int64_t kPauseFirst_ns = 1'000'000'000;
constexpr std::int64_t kPauseMax_ns = 600'000'000'000;

// Port and device number of all that is plugged in: a number is not used again soon. "" without USB.
std::string usb_devices() {
  std::vector<std::string> devices;
  std::error_code code;
  for (std::filesystem::directory_iterator it("/sys/bus/usb/devices", code), end; !code && it != end;
       it.increment(code)) {
    std::string number;
    if (std::ifstream file(it->path() / "devnum"); file >> number)
      devices.push_back(it->path().filename().string() + "=" + number);
  }
  std::sort(devices.begin(), devices.end());
  std::string text;
  for (const auto& device : devices) text += device + " ";
  return text;
}

}  // namespace

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Finder::open(const std::string& uri, const OpenNi2Options& options) {
  if (runtime_ == nullptr) {
    auto runtime = OpenNi2Runtime::get();
    if (!runtime) return runtime.error();
    runtime_ = *runtime;
    usb_devices_ = usb_devices();
    begun_ns_ = monotonic_ns();
  }
  auto source = OpenNi2Source::open(uri, options);
  if (source) pause_ns_ = kPauseFirst_ns;
  return source;
}

Status OpenNi2Finder::begin_again_at_times() {
  const std::string now_there = usb_devices();
  const std::int64_t now_ns = monotonic_ns();
  if (runtime_ != nullptr && now_there == usb_devices_ && now_ns - begun_ns_ < pause_ns_) return Ok{};
  if (now_there == usb_devices_) pause_ns_ = std::min(2 * std::max(pause_ns_, kPauseFirst_ns), kPauseMax_ns);
  runtime_.reset();
  auto runtime = OpenNi2Runtime::get();
  if (!runtime) return runtime.error();
  runtime_ = *runtime;
  usb_devices_ = now_there;
  begun_ns_ = monotonic_ns();
  return Ok{};
}

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Finder::find(const SourceInfo& lost, const OpenNi2Options& options) {
  const std::string scheme = "openni2:";
  const std::string known = lost.uri.substr(lost.uri.rfind(scheme, 0) == 0 ? scheme.size() : 0);
  auto found = open(known, options);
  if (found && (*found)->info().serial == lost.serial) return found;
  if (const auto devices = list_openni2_devices()) {
    for (const auto& device : *devices) {
      if (device.name != lost.name || device.uri == known) continue;
      auto other = open(device.uri, options);
      if (!other) continue;
      const bool it = !lost.serial.empty() && (*other)->info().serial == lost.serial;
      found = std::move(other);
      if (it) return found;
    }
  }
  if (found) return found;
  if (auto begun = begin_again_at_times(); !begun) return begun.error();
  return open(known, options);
}

}  // namespace im2fit::hal
