// SPDX-License-Identifier: Apache-2.0
// A USB device as its host sees it, in software: what device models implement and both of their hosts drive, the
// in-process one of the tests and the usbip one inside the guest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace im2fit::devices {

// USB 2.0 table 9-2.
struct SetupPacket {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

// One thread at a time. Time is the host's to tell, so that a model behaves the same at any speed.
class UsbDevice {
 public:
  virtual ~UsbDevice() = default;
  // The descriptors as they go over the wire (USB 2.0 9.6): the device's, and the configuration's with its interfaces
  // and endpoints behind it.
  virtual std::vector<std::uint8_t> device_descriptor() const = 0;
  virtual std::vector<std::uint8_t> configuration_descriptor() const = 0;
  virtual std::vector<std::uint8_t> string_descriptor(std::uint8_t number) const = 0;  // empty: no such string
  // Requests beyond descriptors: standard ones the device acts on (set configuration, set interface), class and
  // vendor ones. `out`: the bytes from the host. Returns the bytes for the host; nullopt: the device stalls.
  virtual std::optional<std::vector<std::uint8_t>> control(const SetupPacket& setup,
                                                           std::span<const std::uint8_t> out,
                                                           std::int64_t now_us) = 0;
  // The next packet of an isochronous or bulk IN endpoint at `now_us`, at most `size_max` bytes. Empty: nothing to
  // send yet (isochronous: an empty packet; bulk: the device answers NAK and is polled again).
  virtual std::vector<std::uint8_t> read_packet(std::uint8_t endpoint, std::size_t size_max, std::int64_t now_us) = 0;
};

}  // namespace im2fit::devices
