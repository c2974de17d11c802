// SPDX-License-Identifier: Apache-2.0
// Isochronous transfers kept in flight, and the thread that handles their completion.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "hal/usb/libusb_handle.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

class LibusbStream {
 public:
  // `packet_bytes`: what the endpoint carries at a time. `handle` and `sink` must outlive this.
  static Result<std::unique_ptr<LibusbStream>> start(LibusbContext context, libusb_device_handle* handle,
                                                     const UsbStreamSettings& settings, int packet_bytes,
                                                     UsbPacketSink& sink);
  ~LibusbStream();  // cancels, and waits until libusb has given every transfer back

 private:
  LibusbStream(LibusbContext context, UsbPacketSink& sink) : context_(std::move(context)), sink_(sink) {}
  Status submit(libusb_device_handle* handle, const UsbStreamSettings& settings, int packet_bytes);
  static void LIBUSB_CALL on_done(libusb_transfer* transfer);
  void done(libusb_transfer* transfer);
  void deliver(libusb_transfer* transfer);
  void handle_events();
  bool drained();

  LibusbContext context_;
  UsbPacketSink& sink_;
  std::vector<std::uint8_t> buffer_;
  std::vector<libusb_transfer*> transfers_;
  std::thread events_;
  // Completions may run on any thread that waits for libusb, a control transfer's too.
  std::mutex mutex_;
  bool stopping_ = false;
  bool over_ = false;  // the device is gone or refuses
  int in_flight_ = 0;
  int failures_ = 0;  // transfers in a row that brought an error
};

}  // namespace im2fit::hal
