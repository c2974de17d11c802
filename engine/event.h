// SPDX-License-Identifier: Apache-2.0
// How a thread waits for a ring: take a ticket, look at the ring, and wait only if nothing was there. A signal
// between the ticket and the wait makes the wait return at once, so none is lost.
#pragma once

#include <atomic>
#include <cstdint>

namespace im2fit {

class Event {
 public:
  std::uint32_t ticket() const { return count_.load(std::memory_order_acquire); }
  // May return without a signal; the caller looks again.
  void wait(std::uint32_t ticket) const { count_.wait(ticket, std::memory_order_acquire); }
  void signal() {
    count_.fetch_add(1, std::memory_order_release);
    count_.notify_all();
  }

 private:
  std::atomic<std::uint32_t> count_{0};
};

}  // namespace im2fit
