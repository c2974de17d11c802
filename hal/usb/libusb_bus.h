// SPDX-License-Identifier: Apache-2.0
// The machine's USB through libusb.
#pragma once

#include <memory>
#include <span>

#include "core/status.h"
#include "hal/usb/libusb_handle.h"
#include "hal/usb/libusb_stream.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

// A machine without USB gives a bus with no devices.
std::unique_ptr<UsbBus> libusb_bus();

struct UsbOpened {
  UsbDeviceEntry device;  // its port is ""
  std::unique_ptr<UsbTransport> transport;
};
// A device that another process opened for us: Android's UsbManager, or a broker with the rights we lack. The caller
// owns `descriptor` and closes it after the transport. libusb before 1.0.27 then no longer finds devices by itself in
// this process. Errors: invalid_argument (not a USB device), io, no_device.
Result<UsbOpened> open_usb_descriptor(int descriptor);

class LibusbTransport final : public UsbTransport {
 public:
  // Takes the first interface from its kernel driver, if one has it, and gives it back at the end.
  static Result<std::unique_ptr<UsbTransport>> claim(LibusbContext context, LibusbHandle handle);
  ~LibusbTransport() override;

  Result<std::size_t> control_in(const UsbRequest& request, std::span<std::uint8_t> data, int timeout_ms) override;
  Status control_out(const UsbRequest& request, std::span<const std::uint8_t> data, int timeout_ms) override;
  Status start_stream(const UsbStreamSettings& settings, UsbPacketSink& sink) override;
  void stop_stream() override;

 private:
  LibusbTransport(LibusbContext context, LibusbHandle handle)
      : context_(std::move(context)), handle_(std::move(handle)) {}

  LibusbContext context_;
  LibusbHandle handle_;
  int setting_ = 0;
  std::unique_ptr<LibusbStream> stream_;
};

}  // namespace im2fit::hal
