// SPDX-License-Identifier: Apache-2.0
// USB cameras by the words of the command line.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/usb/kinect_open.h"

namespace im2fit::hal {

// `device`: the text after "usb:": a serial number or port, "" for the first camera, or fd=N[,M] for a camera (and
// its motor) opened by another process, which keeps the file descriptors.
Result<std::unique_ptr<KinectSource>> open_usb_camera(const std::string& device, const KinectOptions& options);
Result<std::vector<KinectEntry>> list_usb_cameras();

}  // namespace im2fit::hal
