// SPDX-License-Identifier: Apache-2.0
// A bounded queue of slot indices between exactly one producer and one consumer thread, lock-free and without
// waiting (Event, below, does that). Positions only grow, 64 bit, so they never come round.
//
// Beyond a plain single-producer single-consumer ring the producer may take back the oldest item (a live camera
// drops what no consumer has begun to process). Both ends therefore claim by compare-exchange on `head_`; cells are
// atomics because a claim that loses may have read a cell the producer is rewriting.
#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace im2fit {

inline constexpr std::size_t kCacheLineSize = 64;  // bytes; the value of x86-64 and of the ARM cores we target

class SpscRing {  // NOLINT(clang-analyzer-optin.performance.Padding): the padding is the point
 public:
  // capacity: 1 .. 65536 items, rounded up to a power of two.
  explicit SpscRing(std::uint32_t capacity) {
    assert(capacity >= 1 && capacity <= 65536);
    std::uint64_t size = 1;
    while (size < capacity) size *= 2;
    mask_ = size - 1;
    cells_ = std::make_unique<std::atomic<std::uint32_t>[]>(static_cast<std::size_t>(size));
  }
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  // Producer only. False when full.
  [[nodiscard]] bool try_push(std::uint32_t item) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - cached_head_ > mask_) {
      cached_head_ = head_.load(std::memory_order_acquire);
      if (tail - cached_head_ > mask_) return false;
    }
    cells_[static_cast<std::size_t>(tail & mask_)].store(item, std::memory_order_relaxed);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  // Consumer only. False when empty.
  bool try_pop(std::uint32_t& item) {
    std::uint64_t head = head_.load(std::memory_order_relaxed);
    for (;;) {
      if (head >= cached_tail_) {
        cached_tail_ = tail_.load(std::memory_order_acquire);
        if (head >= cached_tail_) return false;
      }
      if (claim(head, item)) return true;
    }
  }

  // Producer only: removes the oldest item no consumer has claimed. False when there is none.
  bool take_back_oldest(std::uint32_t& item) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    std::uint64_t head = head_.load(std::memory_order_relaxed);
    while (head < tail) {
      if (claim(head, item)) return true;
    }
    return false;
  }

  // Producer only: items not claimed yet; the consumer can only make it smaller.
  std::uint64_t size_seen_by_producer() const {
    return tail_.load(std::memory_order_relaxed) - head_.load(std::memory_order_acquire);
  }
  std::uint64_t capacity() const { return mask_ + 1; }

 private:
  // On failure `head` holds the current head.
  bool claim(std::uint64_t& head, std::uint32_t& item) {
    const std::uint32_t read = cells_[static_cast<std::size_t>(head & mask_)].load(std::memory_order_relaxed);
    if (!head_.compare_exchange_strong(head, head + 1, std::memory_order_acq_rel, std::memory_order_relaxed))
      return false;
    item = read;
    return true;
  }

  std::unique_ptr<std::atomic<std::uint32_t>[]> cells_;
  std::uint64_t mask_ = 0;
  alignas(kCacheLineSize) std::atomic<std::uint64_t> tail_{0};
  std::uint64_t cached_head_ = 0;  // producer's
  alignas(kCacheLineSize) std::atomic<std::uint64_t> head_{0};
  std::uint64_t cached_tail_ = 0;  // consumer's; beside head_, which the consumer writes
};

static_assert(alignof(SpscRing) == kCacheLineSize, "the two ends must not share a cache line");
static_assert(sizeof(SpscRing) == 3 * kCacheLineSize, "constants, producer's line, consumer's line");

// How a thread waits for a ring: take a ticket, look at the ring, and wait only if nothing was there. A signal
// between the ticket and the wait makes the wait return at once, so none is lost.
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
