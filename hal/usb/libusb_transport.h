// SPDX-License-Identifier: Apache-2.0
// An opened device behind the seam.
#pragma once

#include <memory>
#include <span>

#include "hal/usb/libusb_handle.h"
#include "hal/usb/libusb_stream.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

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
