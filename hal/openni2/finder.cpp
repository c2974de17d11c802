// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/finder.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

#include "hal/frame_path.h"

namespace im2fit::hal {
namespace {

constexpr std::int64_t kPauseFirst_ns = 2'000'000'000;
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

Status OpenNi2Finder::begin() {
  runtime_.reset();
  auto runtime = OpenNi2Runtime::get();
  if (!runtime) return runtime.error();
  runtime_ = *runtime;
  return Ok{};
}

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Finder::try_open(const std::string& uri,
                                                               const OpenNi2Options& options) {
  auto source = OpenNi2Source::open(uri, options);
  if (source) searching_ = false;
  return source;
}

bool OpenNi2Finder::time_to_begin_again() {
  const std::int64_t now_ns = monotonic_ns();
  if (std::string now_there = usb_devices(); !searching_ || now_there != usb_devices_) {
    searching_ = true;
    usb_devices_ = std::move(now_there);
    since_ns_ = now_ns;
    pause_ns_ = kPauseFirst_ns;
  }
  if (now_ns - since_ns_ < pause_ns_) return false;
  since_ns_ = now_ns;
  pause_ns_ = std::min(2 * pause_ns_, kPauseMax_ns);
  return true;
}

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Finder::not_listed(const std::string& uri,
                                                                 const OpenNi2Options& options) {
  if (!time_to_begin_again())
    return Error{ErrorCode::no_device,
                 "OpenNI2 lists no " + (uri.empty() ? std::string("camera") : uri) + "; is it plugged in?"};
  if (auto begun = begin(); !begun) return begun.error();
  return try_open(uri, options);
}

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Finder::open(const std::string& uri, const OpenNi2Options& options) {
  if (runtime_ == nullptr) {
    if (auto begun = begin(); !begun) return begun.error();
    return try_open(uri, options);
  }
  const auto devices = list_openni2_devices();
  if (!devices) return devices.error();
  for (const auto& device : *devices)
    if (uri.empty() || device.uri == uri) return try_open(device.uri, options);
  return not_listed(uri, options);
}

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Finder::find(const SourceInfo& lost, const OpenNi2Options& options) {
  const std::string scheme = "openni2:";
  const std::string known = lost.uri.substr(lost.uri.rfind(scheme, 0) == 0 ? scheme.size() : 0);
  if (runtime_ == nullptr) {
    if (auto begun = begin(); !begun) return begun.error();
  }
  const auto devices = list_openni2_devices();
  if (!devices) return devices.error();
  std::unique_ptr<OpenNi2Source> foreign;
  std::optional<Error> wrong;
  for (const auto& device : *devices) {
    if (device.name != lost.name) continue;
    auto other = try_open(device.uri, options);
    if (!other) {
      wrong = other.error();
      continue;
    }
    const bool same = lost.serial.empty() ? device.uri == known : (*other)->info().serial == lost.serial;
    if (same) return other;
    foreign = std::move(*other);
  }
  if (foreign != nullptr) return foreign;
  return wrong ? *wrong : not_listed(known, options);
}

}  // namespace im2fit::hal
