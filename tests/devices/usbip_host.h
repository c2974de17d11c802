// SPDX-License-Identifier: Apache-2.0
// Plugs a UsbDevice into this machine's kernel: the usbip protocol over a socket pair, no network, no privileged
// daemon; root and the module vhci_hcd are needed.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"
#include "tests/devices/usb_device.h"

namespace im2fit::devices {

// Answers the kernel's requests (URBs) from one thread. Isochronous endpoints are paced by CLOCK_MONOTONIC, which is
// the guest's own clock: one packet an interval of the endpoint's descriptor, however late the thread runs. Bulk
// endpoints answer as soon as the device has something.
class UsbipHost {
 public:
  // `socket` stays the caller's. The device must outlive this.
  UsbipHost(UsbDevice& device, int socket);
  // Until the kernel closes its end (unplugged), or stop() from any thread. Error (io): the kernel sent what we do
  // not understand.
  Status run();
  void stop() { stopped_ = true; }

  struct Counts {
    std::uint64_t submitted = 0;
    std::uint64_t unlinked = 0;  // of those, taken back before they were answered
    std::uint64_t packets = 0;   // isochronous
  };
  const Counts& counts() const { return counts_; }

 private:
  struct Urb {
    std::uint32_t number = 0;
    std::uint32_t length = 0;
    std::vector<std::uint32_t> packet_lengths;  // isochronous only
  };
  struct Endpoint {
    bool isochronous = false;
    std::int64_t interval_us = 125;
    std::deque<Urb> waiting;
    std::int64_t clock_us = 0;  // when the next packet is due
  };
  void read_endpoints();
  Status receive();
  Status submit(const std::uint32_t* words);
  Status unlink(const std::uint32_t* words);
  Status answer_control(std::uint32_t number, bool in, const SetupPacket& setup, std::span<const std::uint8_t> out);
  std::optional<std::vector<std::uint8_t>> standard_request(const SetupPacket& setup) const;
  // Answers due requests. Returns the microseconds until the next one is due.
  Result<std::int64_t> serve(std::int64_t now_us);
  Status complete_isochronous(std::uint8_t address, Endpoint& endpoint);
  Status reply(std::uint32_t number, int status, std::span<const std::uint8_t> data, std::uint32_t actual,
               const std::vector<std::uint32_t>& packet_words, std::uint32_t start_frame);
  bool read_exactly(void* to, std::size_t count);
  bool write_exactly(const void* from, std::size_t count);

  UsbDevice& device_;
  int socket_;
  std::atomic<bool> stopped_{false};
  bool unplugged_ = false;
  std::map<std::uint8_t, Endpoint> endpoints_;  // IN endpoints by address
  std::uint32_t frame_number_ = 0;
  Counts counts_;
};

// Hands the kernel a new device on a free high-speed port of vhci_hcd. The socket is for UsbipHost.
struct Attachment {
  int port = -1;
  int socket = -1;
};
Result<Attachment> attach_to_vhci();
// Unplugs; the UsbipHost on the socket then ends. Closing the socket is the caller's.
Status detach_from_vhci(int port);

}  // namespace im2fit::devices
