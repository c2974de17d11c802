// SPDX-License-Identifier: Apache-2.0
// Which Kinects are plugged in, and one of them opened with its motor.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/usb/kinect_source.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

struct KinectEntry {
  std::string id;    // the serial number, or the port ("1-2.3") of a camera that has none of its own
  std::string name;  // "Kinect for Xbox 360"
  UsbDeviceEntry camera;
};

Result<std::vector<KinectEntry>> list_kinects(UsbBus& bus);

// `id`: an entry's id or port; "" takes the first. A motor that is missing or refuses is left out. Errors: no_device
// (lists the cameras found), io, and those of KinectSource::create().
Result<std::unique_ptr<KinectSource>> open_kinect(UsbBus& bus, const std::string& id, const KinectOptions& options);

}  // namespace im2fit::hal
