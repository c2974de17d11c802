// SPDX-License-Identifier: Apache-2.0
// The interface between a camera's protocol and its transport: libusb, or a device model in the process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::hal {

// USB 2.0 table 9-2, without the length: the data's.
struct UsbRequest {
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

// What a stream's packets go to, on a thread of the transport's; never two calls at a time.
class UsbPacketSink {
 public:
  virtual ~UsbPacketSink() = default;
  virtual void packet(std::span<const std::uint8_t> bytes) = 0;
  // The stream is over before it was stopped: the device is gone (no_device) or refuses (io). Called once at most.
  virtual void ended(const Error& why) = 0;
};

struct UsbStreamSettings {
  std::uint8_t endpoint = 0;  // isochronous, IN
  int packet_bytes_min = 0;   // least packet size of the endpoint
  int transfers = 32;         // in flight
  int packets_per_transfer = 16;
};

// A device opened for this process, with its first interface claimed. Closing (the destructor) stops the stream and
// gives the device back to its kernel driver. One thread at a time, but control transfers may run while packets come.
class UsbTransport {
 public:
  virtual ~UsbTransport() = default;
  // Reads up to data.size() bytes; how many came. Errors: no_device, timeout, unsupported (the device stalls: it does
  // not know the request, or not now), io.
  virtual Result<std::size_t> control_in(const UsbRequest& request, std::span<std::uint8_t> data, int timeout_ms) = 0;
  virtual Status control_out(const UsbRequest& request, std::span<const std::uint8_t> data, int timeout_ms) = 0;
  // Chooses the alternate setting that carries such packets and keeps the transfers in flight. Packets that came
  // damaged or not at all are not reported: their numbers are missing. `sink` must live until stop_stream() returns.
  // Errors: no_device, unsupported (no such endpoint), io.
  virtual Status start_stream(const UsbStreamSettings& settings, UsbPacketSink& sink) = 0;
  // Returns when no more calls to the sink can come. Nothing to stop is fine.
  virtual void stop_stream() = 0;
};

struct UsbDeviceEntry {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string port;    // where it is plugged in, "1-2.3" as the kernel says it: bus, then ports
  std::string serial;  // "" when it has none or refuses the query
};

// The devices plugged in now.
class UsbBus {
 public:
  virtual ~UsbBus() = default;
  // Of one vendor, in the order of their ports. A machine without USB has none. Error: io.
  virtual Result<std::vector<UsbDeviceEntry>> list(std::uint16_t vendor) = 0;
  // Errors: no_device (gone meanwhile), io (no permission, another program has it).
  virtual Result<std::unique_ptr<UsbTransport>> open(const UsbDeviceEntry& device) = 0;
};

}  // namespace im2fit::hal
