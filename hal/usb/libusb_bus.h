// SPDX-License-Identifier: Apache-2.0
// The machine's USB through libusb.
#pragma once

#include <memory>

#include "core/status.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

// A machine without USB gives a bus with no devices.
std::unique_ptr<UsbBus> libusb_bus();

struct UsbOpened {
  UsbDeviceEntry device;  // its port is ""
  std::unique_ptr<UsbTransport> transport;
};
// A device another process opened for us: Android's UsbManager, or a broker with the rights we lack. `descriptor`
// stays the caller's, who closes it after the transport. libusb before 1.0.27 then finds no devices by itself any
// more in this process. Errors: invalid_argument (no USB device), io, no_device.
Result<UsbOpened> open_usb_descriptor(int descriptor);

}  // namespace im2fit::hal
