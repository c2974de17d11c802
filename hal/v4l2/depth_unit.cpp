// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/depth_unit.h"

#include <linux/videodev2.h>

#include <cstring>

namespace im2fit::hal {
namespace {

constexpr int kControlsMax = 1024;
constexpr int kDefaultUnit_um = 1000;

Result<std::uint32_t> find_control(VideoDevice& device, const std::string& name, const std::string& what) {
  std::string others;
  std::uint32_t id = 0;
  for (int i = 0; i < kControlsMax; ++i) {
    v4l2_queryctrl entry{};
    entry.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
    if (device.request(VIDIOC_QUERYCTRL, &entry) != 0 || entry.id <= id) break;
    id = entry.id;
    if (entry.type == V4L2_CTRL_TYPE_CTRL_CLASS || (entry.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    const auto* text = reinterpret_cast<const char*>(entry.name);
    const std::string found(text, ::strnlen(text, sizeof entry.name));
    if (found == name) return id;
    if (others.size() < 400) others += (others.empty() ? "'" : ", '") + found + "'";
  }
  return Error{ErrorCode::not_found, what + " has no control '" + name + "'; it has " +
                                         (others.empty() ? std::string("none") : others) +
                                         "; or give the unit itself, ?unit_um=1000"};
}

}  // namespace

Result<int> depth_unit_um(VideoDevice& device, V4l2Format format, const V4l2Options& options,
                          const std::string& what) {
  if (options.unit_um) {
    if (*options.unit_um >= 1 && *options.unit_um <= 100'000) return *options.unit_um;
    return Error{ErrorCode::invalid_argument, what + ": the depth unit is " + std::to_string(*options.unit_um) +
                                                  " micrometres, expected 1 to 100000"};
  }
  if (options.unit_control.empty()) {
    if (format != V4l2Format::inzi) return kDefaultUnit_um;
    return Error{ErrorCode::invalid_argument,
                 what +
                     " delivers INZI, whose depth unit is the camera's own (0.125 mm is usual); give "
                     "?unit_um=125"};
  }
  const auto id = find_control(device, options.unit_control, what);
  if (!id) return id.error();
  v4l2_control control{*id, 0};
  if (const int error = device.request(VIDIOC_G_CTRL, &control); error != 0)
    return device_error(error, what, "reading control '" + options.unit_control + "'");
  if (control.value >= 1 && control.value <= 100'000) return static_cast<int>(control.value);
  return Error{ErrorCode::unsupported, what + ": control '" + options.unit_control + "' is " +
                                           std::to_string(control.value) +
                                           ", expected 1 to 100000 micrometres; give ?unit_um=1000 instead"};
}

}  // namespace im2fit::hal
