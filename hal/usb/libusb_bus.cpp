// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/libusb_bus.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "hal/usb/libusb_handle.h"

namespace im2fit::hal {
namespace {

struct FreeList {
  void operator()(libusb_device** list) const { libusb_free_device_list(list, 1); }
};

LibusbContext owned(libusb_context* context) {
  return {context, [](libusb_context* c) { libusb_exit(c); }};
}

std::string port_of(libusb_device* device) {
  std::array<std::uint8_t, 8> ports{};  // USB nests seven deep
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string text = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) text += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return text;
}

std::string serial_of(libusb_device_handle* handle, std::uint8_t string_number) {
  std::array<unsigned char, 256> text{};
  if (string_number == 0) return "";
  const int length = libusb_get_string_descriptor_ascii(handle, string_number, text.data(), text.size());
  std::string serial;
  for (int i = 0; i < length; ++i) {
    const char c = static_cast<char>(text[static_cast<std::size_t>(i)]);
    if (c > ' ' && c < 0x7F) serial += c;  // it becomes part of a URI
  }
  return serial;
}

UsbDeviceEntry entry_of(libusb_device* device, const libusb_device_descriptor& descriptor) {
  UsbDeviceEntry entry{descriptor.idVendor, descriptor.idProduct, port_of(device), ""};
  libusb_device_handle* opened = nullptr;
  if (descriptor.iSerialNumber != 0 && libusb_open(device, &opened) == 0) {
    const LibusbHandle handle(opened);
    entry.serial = serial_of(opened, descriptor.iSerialNumber);
  }
  return entry;
}

class LibusbBus final : public UsbBus {
 public:
  explicit LibusbBus(LibusbContext context) : context_(std::move(context)) {}

  Result<std::vector<UsbDeviceEntry>> list(std::uint16_t vendor) override {
    std::vector<UsbDeviceEntry> entries;
    for_each([&](libusb_device* device, const libusb_device_descriptor& descriptor) {
      if (descriptor.idVendor == vendor) entries.push_back(entry_of(device, descriptor));
      return false;
    });
    // "9" before "10".
    std::sort(entries.begin(), entries.end(), [](const UsbDeviceEntry& a, const UsbDeviceEntry& b) {
      return std::pair(a.port.size(), a.port) < std::pair(b.port.size(), b.port);
    });
    return entries;
  }

  Result<std::unique_ptr<UsbTransport>> open(const UsbDeviceEntry& wanted) override {
    std::optional<Result<std::unique_ptr<UsbTransport>>> opened;
    for_each([&](libusb_device* device, const libusb_device_descriptor& descriptor) {
      if (descriptor.idVendor != wanted.vendor || descriptor.idProduct != wanted.product ||
          port_of(device) != wanted.port)
        return false;
      libusb_device_handle* handle = nullptr;
      if (const int code = libusb_open(device, &handle); code < 0)
        opened = libusb_error(code, "cannot be opened");
      else
        opened = LibusbTransport::claim(context_, LibusbHandle(handle));
      return true;
    });
    if (!opened) return Error{ErrorCode::no_device, "it is no longer plugged in at " + wanted.port};
    return std::move(*opened);
  }

 private:
  // Until `visit` returns that it is done.
  template <class Visit>
  void for_each(Visit visit) {
    libusb_device** devices = nullptr;
    const ssize_t count = context_ ? libusb_get_device_list(context_.get(), &devices) : 0;
    if (count <= 0 && devices == nullptr) return;
    const std::unique_ptr<libusb_device*, FreeList> list(devices);
    for (ssize_t i = 0; i < count; ++i) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(devices[i], &descriptor) == 0 && visit(devices[i], descriptor)) return;
    }
  }

  LibusbContext context_;  // null: this machine has no USB
};

Result<LibusbContext> context_without_discovery() {
  libusb_context* context = nullptr;
#if LIBUSB_API_VERSION >= 0x0100010A
  libusb_init_option option{};
  option.option = LIBUSB_OPTION_NO_DEVICE_DISCOVERY;
  const int code = libusb_init_context(&context, &option, 1);
#else
  libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
  const int code = libusb_init(&context);
#endif
  if (code < 0) return libusb_error(code, "libusb does not start");
  return owned(context);
}

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

std::unique_ptr<UsbBus> libusb_bus() {
  libusb_context* context = nullptr;
  const int code = libusb_init(&context);
  return std::make_unique<LibusbBus>(code < 0 ? nullptr : owned(context));
}

Result<UsbOpened> open_usb_descriptor(int descriptor) {
  const std::string what = "file descriptor " + std::to_string(descriptor);
  if (descriptor < 0) return Error{ErrorCode::invalid_argument, what + " is negative; expected an opened USB device"};
  auto context = context_without_discovery();
  if (!context) return context.error();
  libusb_device_handle* wrapped = nullptr;
  if (const int code = libusb_wrap_sys_device(context->get(), static_cast<intptr_t>(descriptor), &wrapped); code < 0)
    return Error{ErrorCode::invalid_argument, what + " is not an opened USB device (" + libusb_strerror(code) +
                                                  "); expected /dev/bus/usb/BUS/DEVICE"};
  LibusbHandle handle(wrapped);
  libusb_device_descriptor about{};
  if (const int code = libusb_get_device_descriptor(libusb_get_device(wrapped), &about); code < 0)
    return libusb_error(code, what);
  UsbOpened opened;
  opened.device = {about.idVendor, about.idProduct, "", serial_of(wrapped, about.iSerialNumber)};
  auto transport = LibusbTransport::claim(*context, std::move(handle));
  if (!transport) return Error{transport.error().code, what + ": " + transport.error().message};
  opened.transport = std::move(*transport);
  return opened;
}

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
