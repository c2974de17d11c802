// SPDX-License-Identifier: Apache-2.0
// The latest value of one writer for any number of readers; neither ever waits for the other to be scheduled.
//
// Two copies, each under a sequence lock. The writer always writes the copy that is not current, so a writer
// stopped midway leaves the current copy readable. Words are atomics with release stores and acquire loads: a
// reader that meets any new word must also see the odd count before it, without fences (which TSan cannot follow).
// Boehm, "Can seqlocks get along with programming language memory models?", MSPC 2012.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace im2fit {

template <class T>
class Snapshot {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Snapshot(const T& value = T{}) {
    publish(value);
    publish(value);
  }
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

  // One thread at a time.
  void publish(const T& value) {
    const std::uint32_t target = 1 - current_.load(std::memory_order_relaxed);
    Copy& copy = copies_[target];
    Words words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint32_t count = copy.count.load(std::memory_order_relaxed);
    copy.count.store(count + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < kWordCount; ++i) copy.words[i].store(words[i], std::memory_order_release);
    copy.count.store(count + 2, std::memory_order_release);
    current_.store(target, std::memory_order_release);
  }

  // Any thread. Repeats only when the writer published twice meanwhile.
  T read() const {
    for (;;) {
      const Copy& copy = copies_[current_.load(std::memory_order_acquire)];
      const std::uint32_t before = copy.count.load(std::memory_order_acquire);
      Words words;
      for (std::size_t i = 0; i < kWordCount; ++i) words[i] = copy.words[i].load(std::memory_order_acquire);
      const std::uint32_t after = copy.count.load(std::memory_order_relaxed);
      if (before != after || (before & 1U) != 0) continue;
      T value;
      std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
      return value;
    }
  }

 private:
  static constexpr std::size_t kWordCount = (sizeof(T) + 3) / 4;
  using Words = std::array<std::uint32_t, kWordCount>;
  struct alignas(64) Copy {
    std::atomic<std::uint32_t> count{0};
    std::array<std::atomic<std::uint32_t>, kWordCount> words{};
  };
  std::array<Copy, 2> copies_;
  std::atomic<std::uint32_t> current_{0};
};

}  // namespace im2fit
