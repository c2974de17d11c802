// SPDX-License-Identifier: Apache-2.0
// Buffers sized for the largest picture, of which a frame needs a part or none: what is never written takes no
// memory.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace im2fit {

// `size` values that are 0, as a vector's; but pages become resident where they are written first, for calloc() takes
// large blocks from the system, whose new pages are zero, and leaves them untouched.
template <class T>
class LazyZeros {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  LazyZeros() = default;
  explicit LazyZeros(std::size_t size) : data_(static_cast<T*>(std::calloc(size, sizeof(T)))), size_(size) {
    if (data_ == nullptr && size > 0) throw std::bad_alloc();
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
    void operator()(T* data) const { std::free(data); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

}  // namespace im2fit
