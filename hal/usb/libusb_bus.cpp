// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/libusb_bus.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "hal/usb/libusb_handle.h"
#include "hal/usb/libusb_transport.h"

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
  // Until `visit` says it has what it wants.
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

}  // namespace im2fit::hal
