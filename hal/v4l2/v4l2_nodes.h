// SPDX-License-Identifier: Apache-2.0
// Which of the system's video nodes is the depth camera.
#pragma once

#include <string>

#include "core/status.h"

namespace im2fit::hal {

// The serial number of the USB device behind /dev/videoN, "" when there is none or the kernel does not report it.
std::string v4l2_serial(const std::string& path);
// The node `path`, or when "" the first depth camera; with `serial` not "" the one with that number: nodes are
// numbered anew with every plugging in. Error: no_device, listing what is there.
Result<std::string> find_v4l2_node(const std::string& path, const std::string& serial);

}  // namespace im2fit::hal
