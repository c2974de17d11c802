// SPDX-License-Identifier: Apache-2.0
// The mask of the latest frame, for im2fit_mask: a copy, since the frame's place in the pool is used again.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "capi/include/im2fit/im2fit.h"
#include "engine/engine.h"

namespace im2fit::c {

class MaskKeeper {
 public:
  // Of the engine's frames, before the first.
  void prepare(int width, int height) {
    pixel_count_ = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  // On the engine's thread, after each frame. Keeps nothing before the first call of read().
  void keep(const FrameSeen& frame);
  // Any thread. Waits for keep() at most, for one copy of a mask. NOT_FOUND: no frame since the first call, or since
  // forget(). TOO_SMALL: `info` is written. With `mask` null only `info` is.
  int read(std::uint8_t* mask, std::size_t capacity, im2fit_mask_info& info);
  void forget();

 private:
  std::size_t pixel_count_ = 0;
  std::atomic<bool> wanted_{false};
  std::mutex mutex_;                  // of all below
  std::vector<std::uint8_t> pixels_;  // allocated by the first read()
  im2fit_mask_info info_{};
  bool kept_ = false;
};

}  // namespace im2fit::c
