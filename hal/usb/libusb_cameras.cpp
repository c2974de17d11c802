// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/libusb_cameras.h"

#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "hal/usb/kinect_protocol.h"
#include "hal/usb/libusb_bus.h"

namespace im2fit::hal {
namespace {

std::optional<int> number(std::string_view text) {
  int value = -1;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

Result<std::unique_ptr<KinectSource>> open_descriptors(const std::string& words, const KinectOptions& options) {
  const auto comma = words.find(',');
  const auto camera_fd = number(std::string_view(words).substr(0, comma));
  const auto motor_fd = comma == std::string::npos ? std::nullopt : number(std::string_view(words).substr(comma + 1));
  if (!camera_fd || (comma != std::string::npos && !motor_fd))
    return Error{ErrorCode::invalid_argument, "usb:fd=" + words +
                                                  ": expected usb:fd=CAMERA or usb:fd=CAMERA,MOTOR, "
                                                  "numbers of open file descriptors"};
  auto camera = open_usb_descriptor(*camera_fd);
  if (!camera) return camera.error();
  if (camera->device.vendor != kinect::kVendor ||
      (camera->device.product != kinect::kCamera && camera->device.product != kinect::kCameraForWindows))
    return Error{ErrorCode::unsupported, "usb:fd=" + words + " is a USB device, but no Kinect camera"};
  std::unique_ptr<UsbTransport> motor;
  if (motor_fd) {
    auto opened = open_usb_descriptor(*motor_fd);
    if (!opened) return opened.error();
    motor = std::move(opened->transport);
  }
  const bool xbox = camera->device.product == kinect::kCamera;
  return KinectSource::create(
      std::move(camera->transport), std::move(motor),
      {"usb:fd=" + words, xbox ? "Kinect for Xbox 360" : "Kinect for Windows", camera->device.serial}, options);
}

}  // namespace

Result<std::unique_ptr<KinectSource>> open_usb_camera(const std::string& device, const KinectOptions& options) {
  if (device.rfind("fd=", 0) == 0) return open_descriptors(device.substr(3), options);
  return open_kinect(*libusb_bus(), device, options);
}

Result<std::vector<KinectEntry>> list_usb_cameras() {
  return list_kinects(*libusb_bus());
}

}  // namespace im2fit::hal
