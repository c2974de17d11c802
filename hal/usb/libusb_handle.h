// SPDX-License-Identifier: Apache-2.0
// libusb's objects with owners, and its codes as errors. Only libusb_*.cpp include this.
#pragma once

#include <libusb.h>

#include <memory>
#include <string>

#include "core/status.h"

namespace im2fit::hal {

using LibusbContext = std::shared_ptr<libusb_context>;

struct LibusbClose {
  void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};
using LibusbHandle = std::unique_ptr<libusb_device_handle, LibusbClose>;

// `code` is a negative libusb return value.
Error libusb_error(int code, const std::string& what);

}  // namespace im2fit::hal
