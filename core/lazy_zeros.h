// SPDX-License-Identifier: Apache-2.0
// Buffers sized for the largest picture, of which a frame needs a part or none: pages never written take no memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace im2fit {

// Large blocks come from the system, whose new pages are zero, and go back to it. calloc() does the same until a
// block was freed: from then on glibc keeps such blocks and writes their zeros, so that a second engine took twice
// the memory.
void* lazy_zero_bytes(std::size_t size);
void free_lazy_zero_bytes(void* bytes, std::size_t size);

// `size` values that are 0, as a vector's; but pages become resident where they are written first.
template <class T>
class LazyZeros {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  LazyZeros() = default;
  explicit LazyZeros(std::size_t size) : size_(size) {
    if (size > SIZE_MAX / sizeof(T)) throw std::bad_alloc();
    data_ = std::unique_ptr<T, Free>(static_cast<T*>(lazy_zero_bytes(size * sizeof(T))), Free{size * sizeof(T)});
  }
  LazyZeros(LazyZeros&& other) noexcept : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)) {}
  LazyZeros& operator=(LazyZeros&& other) noexcept {
    data_ = std::move(other.data_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  std::size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    std::size_t bytes = 0;
    void operator()(T* data) const { free_lazy_zero_bytes(data, bytes); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

}  // namespace im2fit
