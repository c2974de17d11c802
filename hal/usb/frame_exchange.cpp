// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/frame_exchange.h"

#include <algorithm>
#include <chrono>

namespace im2fit::hal {

FrameExchange::FrameExchange(std::size_t frame_bytes) {
  for (auto& buffer : buffers_) buffer.resize(frame_bytes);
  reset();
}

void FrameExchange::reset() {
  const std::lock_guard lock(mutex_);
  free_.fill(true);
  filling_ = 0;
  free_[0] = false;
  reading_ = -1;
  first_ = count_ = 0;
  ended_.reset();
  dropped_ = dropped_damaged_ = 0;
}

// The oldest entry leaves the queue; its buffer is free.
void FrameExchange::pop_locked() {
  const Entry& oldest = queue_[first_];
  ++(oldest.damaged ? dropped_damaged_ : dropped_);
  if (oldest.buffer >= 0) free_[static_cast<std::size_t>(oldest.buffer)] = true;
  first_ = (first_ + 1) % kQueue;
  --count_;
}

void FrameExchange::push_locked(const Entry& entry) {
  if (count_ == kQueue) pop_locked();
  queue_[(first_ + count_) % kQueue] = entry;
  ++count_;
}

void FrameExchange::publish(Entry entry) {
  {
    const std::lock_guard lock(mutex_);
    entry.buffer = filling_;
    entry.bytes = filling();
    push_locked(entry);
    auto next = std::find(free_.begin(), free_.end(), true);
    while (next == free_.end()) {
      pop_locked();
      next = std::find(free_.begin(), free_.end(), true);
    }
    *next = false;
    filling_ = static_cast<int>(next - free_.begin());
  }
  changed_.notify_one();
}

void FrameExchange::publish_damaged(Entry entry) {
  {
    const std::lock_guard lock(mutex_);
    entry.damaged = true;
    entry.buffer = -1;
    entry.bytes = nullptr;
    push_locked(entry);
  }
  changed_.notify_one();
}

void FrameExchange::end(const Error& why) {
  {
    const std::lock_guard lock(mutex_);
    if (!ended_) ended_ = why;
  }
  changed_.notify_one();
}

std::optional<FrameExchange::Entry> FrameExchange::take(int timeout_ms) {
  std::unique_lock lock(mutex_);
  if (reading_ >= 0) free_[static_cast<std::size_t>(reading_)] = true;
  reading_ = -1;
  const auto ready = [&] { return count_ > 0 || ended_; };
  if (timeout_ms > 0 && !ready()) changed_.wait_for(lock, std::chrono::milliseconds(timeout_ms), ready);
  if (count_ == 0) return std::nullopt;
  const Entry entry = queue_[first_];
  first_ = (first_ + 1) % kQueue;
  --count_;
  reading_ = entry.buffer;
  return entry;
}

std::optional<Error> FrameExchange::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_;
}

std::uint64_t FrameExchange::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

std::uint64_t FrameExchange::dropped_damaged() const {
  const std::lock_guard lock(mutex_);
  return dropped_damaged_;
}

}  // namespace im2fit::hal
