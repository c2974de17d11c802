// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/kinect_open.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "hal/usb/kinect_protocol.h"

namespace im2fit::hal {
namespace {

using namespace kinect;

bool is_camera(const UsbDeviceEntry& device) {
  return device.vendor == kVendor && (device.product == kCamera || device.product == kCameraForWindows);
}

// The hub a device hangs on.
std::string parent(const std::string& port) {
  const auto cut = port.find_last_of(".-");
  return cut == std::string::npos ? port : port.substr(0, cut);
}

// Later models call themselves 0000000000000000.
bool has_own_serial(const UsbDeviceEntry& device) {
  return device.serial.find_first_not_of('0') != std::string::npos;
}

// A Kinect is a hub with camera and motor on it. Where several of each hang on one hub (a virtual one), the first
// camera has the first motor.
std::optional<UsbDeviceEntry> motor_of(const UsbDeviceEntry& camera, const std::vector<UsbDeviceEntry>& devices) {
  if (camera.product != kCamera) return std::nullopt;
  std::vector<UsbDeviceEntry> cameras, motors, all_motors;
  for (const auto& device : devices) {
    const bool same_hub = parent(device.port) == parent(camera.port);
    if (device.product == kCamera && same_hub) cameras.push_back(device);
    if (device.product == kMotor && same_hub) motors.push_back(device);
    if (device.product == kMotor) all_motors.push_back(device);
  }
  for (auto* list : {&cameras, &motors})
    std::sort(list->begin(), list->end(), [](const UsbDeviceEntry& a, const UsbDeviceEntry& b) {
      return std::pair(a.port.size(), a.port) < std::pair(b.port.size(), b.port);  // "9" before "10"
    });
  for (std::size_t i = 0; i < cameras.size() && i < motors.size(); ++i)
    if (cameras[i].port == camera.port) return motors[i];
  const auto all_cameras = std::count_if(devices.begin(), devices.end(), is_camera);
  if (motors.empty() && all_motors.size() == 1 && all_cameras == 1) return all_motors.front();
  return std::nullopt;
}

std::vector<KinectEntry> entries_of(const std::vector<UsbDeviceEntry>& devices) {
  std::vector<KinectEntry> entries;
  for (const auto& device : devices) {
    if (!is_camera(device)) continue;
    const bool twice = std::any_of(devices.begin(), devices.end(), [&](const UsbDeviceEntry& other) {
      return is_camera(other) && other.port != device.port && other.serial == device.serial;
    });
    entries.push_back({has_own_serial(device) && !twice ? device.serial : device.port,
                       device.product == kCamera ? "Kinect for Xbox 360" : "Kinect for Windows", device});
  }
  return entries;
}

}  // namespace

Result<std::vector<KinectEntry>> list_kinects(UsbBus& bus) {
  const auto devices = bus.list(kVendor);
  if (!devices) return devices.error();
  return entries_of(*devices);
}

Result<std::unique_ptr<KinectSource>> open_kinect(UsbBus& bus, const std::string& id, const KinectOptions& options) {
  const auto devices = bus.list(kVendor);
  if (!devices) return devices.error();
  const auto entries = entries_of(*devices);
  const auto wanted = std::find_if(entries.begin(), entries.end(), [&](const KinectEntry& entry) {
    return id.empty() || entry.id == id || entry.camera.port == id;
  });
  if (wanted == entries.end()) {
    std::string there;
    for (const auto& entry : entries) there += (there.empty() ? "" : ", ") + std::string("usb:") + entry.id;
    return Error{ErrorCode::no_device,
                 (id.empty() ? "there is no USB depth camera" : "there is no camera usb:" + id) + std::string(" (") +
                     (there.empty() ? "none is plugged in" : "there are " + there) +
                     "); plug it in, its own power supply too"};
  }
  auto camera = bus.open(wanted->camera);
  if (!camera)
    return Error{camera.error().code, wanted->name + " (usb:" + wanted->id + "): " + camera.error().message};
  std::unique_ptr<UsbTransport> motor;
  if (const auto device = motor_of(wanted->camera, *devices))
    if (auto opened = bus.open(*device)) motor = std::move(*opened);
  return KinectSource::create(std::move(*camera), std::move(motor),
                              {"usb:" + wanted->id, wanted->name, wanted->camera.serial}, options);
}

}  // namespace im2fit::hal
