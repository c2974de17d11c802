// SPDX-License-Identifier: Apache-2.0
// The common part of all tests of kernel variants: seeded biased data, buffers between guard pages, the same call on
// every variant. The idea is dav1d's checkasm: the contract is `portable`, every other tier must give its bits.
//
//   checkasm::Trial trial;                           // prints the seed; IM2FIT_CHECK_SEED=N repeats one
//   for (int width : checkasm::odd_sizes(64)) {
//     IM2FIT_CHECK_PARAMETERS(trial, width);           // what a failure prints beside the seed
//     checkasm::Buffer<std::uint16_t> in(width, trial.next_end()), want(width), got(width);
//     trial.fill(in.span());
//     kernel_portable(in.data(), width, want.data());
//     checkasm::each_simd(kKernels, [&](const auto& variant) {
//       variant.function(in.data(), width, got.data());
//       checkasm::expect_same_bits(want.span(), got.span());
//     });
//   }
#pragma once

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/rng.h"
#include "kernels/tier.h"

namespace im2fit::checkasm {

// Which end of a buffer lies against the page that may not be touched. The other end is watched by canaries.
enum class Guard { after, before };

// `count` values, uninitialised but for a pattern; reading or writing past the guarded end is a fault, writing up to
// 64 bytes past the other one fails the test. The guarded-end address is aligned only as T is: kernels may not assume
// more unless their contract says so.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Buffer(std::size_t count, Guard guard = Guard::after) : count_(count) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t bytes = count * sizeof(T);
    inner_ = (bytes + kCanary + page - 1) / page * page;
    mapped_ = inner_ + 2 * page;
    void* map = mmap(nullptr, mapped_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (map == MAP_FAILED) std::abort();
    base_ = static_cast<std::byte*>(map);
    std::byte* inner = base_ + page;
    if (mprotect(inner, inner_, PROT_READ | PROT_WRITE) != 0) std::abort();
    std::memset(inner, kPattern, inner_);
    std::byte* first = guard == Guard::after ? inner + inner_ - bytes : inner;
    canary_ = guard == Guard::after ? first - kCanary : first + bytes;
    data_ = reinterpret_cast<T*>(first);
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() {
    for (std::size_t i = 0; i < kCanary; ++i) {
      if (canary_[i] != std::byte{kPattern}) {
        ADD_FAILURE() << "a value beside the buffer of " << count_ << " was written";
        break;
      }
    }
    munmap(base_, mapped_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return count_; }
  std::span<T> span() { return {data_, count_}; }
  std::span<const T> span() const { return {data_, count_}; }
  T& operator[](std::size_t i) { return data_[i]; }
  void refill() { std::memset(static_cast<void*>(data_), kPattern, count_ * sizeof(T)); }

 private:
  static constexpr std::size_t kCanary = 64;
  static constexpr int kPattern = 0xA5;
  std::size_t count_, inner_ = 0, mapped_ = 0;
  std::byte* base_ = nullptr;
  std::byte* canary_ = nullptr;
  T* data_ = nullptr;
};

class Trial {
 public:
  Trial() : seed_(chosen_seed()), rng_(seed_) {}

  std::uint64_t seed() const { return seed_; }
  Rng& rng() { return rng_; }
  // Both ends of buffers get their turn.
  Guard next_end() { return (ends_++ & 1) == 0 ? Guard::after : Guard::before; }

  // One value in eight within 16 of `low`, one within 16 of `high`, the rest anywhere between, both included.
  template <class T>
  T biased(T low, T high) {
    static_assert(std::is_integral_v<T>);
    const auto range = static_cast<std::uint64_t>(static_cast<std::int64_t>(high) - static_cast<std::int64_t>(low));
    const std::uint64_t near = std::min<std::uint64_t>(range, 15);
    const std::uint64_t which = draw(8);
    if (which == 0) return static_cast<T>(static_cast<std::int64_t>(low) + static_cast<std::int64_t>(draw(near + 1)));
    if (which == 1)
      return static_cast<T>(static_cast<std::int64_t>(high) - static_cast<std::int64_t>(draw(near + 1)));
    return static_cast<T>(static_cast<std::int64_t>(low) + static_cast<std::int64_t>(draw(range + 1)));
  }
  float between(float low, float high) { return low + (high - low) * static_cast<float>(rng_.uniform()); }

  // The whole range of an integer type; pass the kernel's own bounds where its contract has some.
  template <class T>
  void fill(std::span<T> values, T low = std::numeric_limits<T>::min(), T high = std::numeric_limits<T>::max()) {
    for (T& value : values) value = biased(low, high);
  }
  // One value in eight at each bound exactly, one in eight zero.
  void fill(std::span<float> values, float low, float high) {
    for (float& value : values) {
      const std::uint64_t which = draw(8);
      value = which == 0 ? low : which == 1 ? high : which == 2 ? 0.0F : between(low, high);
    }
  }

 private:
  static std::uint64_t chosen_seed() {
    const char* text = std::getenv("IM2FIT_CHECK_SEED");
    return text != nullptr ? std::strtoull(text, nullptr, 10) : 20240531;
  }
  std::uint64_t draw(std::uint64_t count) { return count <= 1 ? 0 : rng_.next() % count; }

  std::uint64_t seed_;
  Rng rng_;
  unsigned ends_ = 0;
};

// Small counts one by one, then those about every multiple of a vector's length up to `last`.
inline std::vector<int> odd_sizes(int last) {
  std::vector<int> sizes;
  for (int n = 1; n <= last; ++n) {
    if (n <= 20 || n % 8 <= 1 || n % 8 == 7) sizes.push_back(n);
  }
  return sizes;
}

// Calls `check(variant)` for every hand-written variant this machine can run, naming it in failures.
template <class Variants, class Check>
void each_simd(const Variants& variants, Check check) {
  for (const auto& variant : variants) {
    if (variant.tier == Tier::ref || variant.tier == Tier::portable || !tier_available(variant.tier)) continue;
    SCOPED_TRACE(std::string("variant ") + variant.name);
    check(variant);
    if (testing::Test::HasFatalFailure()) return;
  }
}

template <class T>
void expect_same_bits(std::span<const T> want, std::span<const T> got) {
  ASSERT_EQ(want.size(), got.size());
  for (std::size_t i = 0; i < want.size(); ++i) {
    if (std::memcmp(&want[i], &got[i], sizeof(T)) != 0) {
      ADD_FAILURE() << "value " << i << " of " << want.size() << ": portable " << +want[i] << ", got " << +got[i];
      return;
    }
  }
}
template <class T>
void expect_same_bits(const Buffer<T>& want, const Buffer<T>& got) {
  expect_same_bits(want.span(), got.span());
}

}  // namespace im2fit::checkasm

// Names the seed and the parameters in every failure of this scope.
#define IM2FIT_CHECK_PARAMETERS(trial, parameters) \
  SCOPED_TRACE(::testing::Message() << "IM2FIT_CHECK_SEED=" << (trial).seed() << ", " #parameters " = " << parameters)
