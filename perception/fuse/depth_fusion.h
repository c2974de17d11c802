// SPDX-License-Identifier: Apache-2.0
// Temporal mean of a standing person's depth: averaging frames before the features gains three times as much as finer
// arithmetic (facts: L1 of FPFH between two frames 46 of 300, after 15 fused frames 20).
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "core/lazy_zeros.h"

namespace im2fit {

class DepthFusion {
 public:
  DepthFusion(int width, int height);
  void reset();
  // Adds the masked pixels inside the inclusive box. At most 4095 frames.
  void add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max);
  int frame_count() const { return frame_count_; }
  // Pixels seen in at least half the frames, as depth in 1/16 mm (0 = none; nearer than 4095 mm) and mask.
  void finish();
  ImageView<const std::uint16_t> depth_q4() const { return {depth_q4_.data(), width_, height_}; }
  MaskView mask() const { return {mask_.data(), width_, height_}; }

 private:
  int width_, height_;
  int frame_count_ = 0;
  LazyZeros<std::uint32_t> sum_mm_;
  LazyZeros<std::uint16_t> count_;
  LazyZeros<std::uint16_t> depth_q4_;
  LazyZeros<std::uint8_t> mask_;
};

}  // namespace im2fit
