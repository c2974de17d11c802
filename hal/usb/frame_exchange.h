// SPDX-License-Identifier: Apache-2.0
// Passes frames from the receiving thread to the consuming thread.
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "core/status.h"

namespace im2fit::hal {

// A buffer belongs to one side at a time, so its bytes are touched without the lock: only indices change hands under
// it. One producer, one consumer. No allocation after construction. If frames are not taken, the oldest is dropped
// for the newest.
class FrameExchange {
 public:
  struct Entry {
    std::uint64_t number = 0;  // of the frame, as the producer counts
    std::int64_t host_ns = 0;
    std::int64_t device_us = -1;
    bool damaged = false;  // a frame that must not be used: it has no bytes
    int packets_received = 0;
    const std::uint8_t* bytes = nullptr;  // the consumer's until its next take()
    int buffer = -1;
  };

  explicit FrameExchange(std::size_t frame_bytes);

  // Call while both sides are stopped: drops the waiting frames and the end.
  void reset();

  // Producer.
  std::uint8_t* filling() { return buffers_[static_cast<std::size_t>(filling_)].data(); }
  void publish(Entry entry);          // filling()'s bytes, and a new filling(); `bytes` and `buffer` are set here
  void publish_damaged(Entry entry);  // filling() stays
  void end(const Error& why);         // nothing more will come

  // Consumer. None: nothing came in time. What was published before the end is still given.
  std::optional<Entry> take(int timeout_ms);
  std::optional<Error> ended() const;
  std::uint64_t dropped() const;  // good frames pushed out by newer ones, since reset()
  std::uint64_t dropped_damaged() const;

 private:
  static constexpr int kBuffers = 4;  // one is filled, one is read, two wait
  static constexpr std::size_t kQueue = 8;

  void pop_locked();
  void push_locked(const Entry& entry);

  std::array<std::vector<std::uint8_t>, kBuffers> buffers_;
  int filling_ = 0;  // the producer's alone, like the buffer
  int reading_ = -1;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Entry, kQueue> queue_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::array<bool, kBuffers> free_{};
  std::optional<Error> ended_;
  std::uint64_t dropped_ = 0;
  std::uint64_t dropped_damaged_ = 0;
};

}  // namespace im2fit::hal
