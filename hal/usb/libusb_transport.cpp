// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/libusb_transport.h"

#include <string>
#include <utility>

namespace im2fit::hal {
namespace {

constexpr int kInterface = 0;

struct Carrier {
  int setting = -1;  // none
  int packet_bytes = 0;
};

// A high-speed endpoint carries up to three times wMaxPacketSize's low 11 bits in a microframe (USB 2.0 9.6.6).
int bytes_per_microframe(const libusb_endpoint_descriptor& endpoint) {
  return (endpoint.wMaxPacketSize & 0x7FF) * (1 + ((endpoint.wMaxPacketSize >> 11) & 3));
}

// The alternate setting that reserves least and carries enough.
Carrier find_carrier(const libusb_interface& interface, const UsbStreamSettings& wanted) {
  Carrier best;
  for (int i = 0; i < interface.num_altsetting; ++i) {
    const libusb_interface_descriptor& setting = interface.altsetting[i];
    for (int k = 0; k < setting.bNumEndpoints; ++k) {
      const libusb_endpoint_descriptor& endpoint = setting.endpoint[k];
      const int bytes = bytes_per_microframe(endpoint);
      if (endpoint.bEndpointAddress != wanted.endpoint || bytes < wanted.packet_bytes_min ||
          (endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_ISOCHRONOUS)
        continue;
      if (best.setting < 0 || bytes < best.packet_bytes) best = {setting.bAlternateSetting, bytes};
    }
  }
  return best;
}

}  // namespace

Error libusb_error(int code, const std::string& what) {
  const std::string text = what + " (" + libusb_strerror(code) + ")";
  switch (code) {
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return {ErrorCode::no_device, text + "; is it still plugged in?"};
    case LIBUSB_ERROR_TIMEOUT:
      return {ErrorCode::timeout, text};
    case LIBUSB_ERROR_PIPE:
      return {ErrorCode::unsupported, text + ": the device stalls"};
    case LIBUSB_ERROR_ACCESS:
      return {ErrorCode::io, text + "; install hal/usb/60-im2fit-kinect.rules (docs/cameras) and plug it in again"};
    case LIBUSB_ERROR_BUSY:
      return {ErrorCode::io, text + "; is another program using it?"};
    default:
      return {ErrorCode::io, text};
  }
}

Result<std::unique_ptr<UsbTransport>> LibusbTransport::claim(LibusbContext context, LibusbHandle handle) {
  // Detaches gspca_kinect when claiming and attaches it again when releasing. Not everywhere are there such drivers.
  libusb_set_auto_detach_kernel_driver(handle.get(), 1);
  if (const int code = libusb_claim_interface(handle.get(), kInterface); code < 0)
    return libusb_error(code, "cannot be claimed");
  return std::unique_ptr<UsbTransport>(new LibusbTransport(std::move(context), std::move(handle)));
}

LibusbTransport::~LibusbTransport() {
  stop_stream();
  libusb_release_interface(handle_.get(), kInterface);
}

Result<std::size_t> LibusbTransport::control_in(const UsbRequest& request, std::span<std::uint8_t> data,
                                                int timeout_ms) {
  const int got =
      libusb_control_transfer(handle_.get(), request.type, request.request, request.value, request.index, data.data(),
                              static_cast<std::uint16_t>(data.size()), static_cast<unsigned>(timeout_ms));
  if (got < 0) return libusb_error(got, "reading over USB failed");
  return static_cast<std::size_t>(got);
}

Status LibusbTransport::control_out(const UsbRequest& request, std::span<const std::uint8_t> data, int timeout_ms) {
  // libusb copies what it sends; its interface is the same for both directions.
  const int sent =
      libusb_control_transfer(handle_.get(), request.type, request.request, request.value, request.index,
                              const_cast<std::uint8_t*>(data.data()), static_cast<std::uint16_t>(data.size()),
                              static_cast<unsigned>(timeout_ms));
  if (sent < 0) return libusb_error(sent, "writing over USB failed");
  if (static_cast<std::size_t>(sent) != data.size())
    return Error{ErrorCode::io, "only " + std::to_string(sent) + " of " + std::to_string(data.size()) +
                                    " bytes were taken over USB"};
  return Ok{};
}

Status LibusbTransport::start_stream(const UsbStreamSettings& settings, UsbPacketSink& sink) {
  stop_stream();
  libusb_config_descriptor* configuration = nullptr;
  const int read = libusb_get_active_config_descriptor(libusb_get_device(handle_.get()), &configuration);
  if (read < 0) return libusb_error(read, "its descriptors cannot be read");
  Carrier carrier;
  if (configuration->bNumInterfaces > kInterface)
    carrier = find_carrier(configuration->interface[kInterface], settings);
  libusb_free_config_descriptor(configuration);
  if (carrier.setting < 0)
    return Error{ErrorCode::unsupported, "it has no isochronous endpoint " + std::to_string(settings.endpoint & 0xF) +
                                             " for packets of " + std::to_string(settings.packet_bytes_min) +
                                             " bytes; is it on a USB 2 port?"};
  if (carrier.setting != setting_) {
    if (const int code = libusb_set_interface_alt_setting(handle_.get(), kInterface, carrier.setting); code < 0)
      return libusb_error(code, "no bandwidth for its stream; use a port of its own");
    setting_ = carrier.setting;
  }
  auto stream = LibusbStream::start(context_, handle_.get(), settings, carrier.packet_bytes, sink);
  if (!stream) return stream.error();
  stream_ = std::move(*stream);
  return Ok{};
}

void LibusbTransport::stop_stream() {
  stream_.reset();
}

}  // namespace im2fit::hal
