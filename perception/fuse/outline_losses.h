// SPDX-License-Identifier: Apache-2.0
// What a sensor loses beside a person's outline: a projector's shadow on one side, pixels of two surfaces on both,
// nothing. Distinguishes sensors whose driver has smoothed the noise away.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"

namespace im2fit {

// Samples across the mask's outline to all four sides, on every kStep-th row and column, at the pixels beside it:
// those without data that are followed by data are lost. Where no data follow, the background is out of range and is
// not counted. Frames beyond the first few thousand pixels are not read. Integers until the last division; no
// allocation; not shareable between threads.
class OutlineLosses {
 public:
  static constexpr int kStep = 8;
  void reset();
  // The outline inside the inclusive box, as DepthFusion::add().
  void add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max);
  // Share of lost pixels, 0 to 1; NaN below kPixelsMin.
  static constexpr std::uint32_t kPixelsMin = 30;
  float lost() const;
  // How much larger that share is on one side than on the opposite one, the larger of the two ways: a projector
  // stands beside its camera. 0 until both sides of a way have kPixelsMin.
  float one_sided() const;

 private:
  struct Side {
    std::uint32_t pixels = 0, lost = 0;
  };
  enum : std::size_t { kLeft, kRight, kAbove, kBelow, kSides };
  struct Line;
  static void scan(const Line& line, Side& before, Side& after);
  std::array<Side, kSides> sides_;
};

}  // namespace im2fit
