// SPDX-License-Identifier: Apache-2.0
#include "perception/fuse/depth_fusion.h"

#include <algorithm>
#include <cstddef>

#include "kernels/average/average.h"
#include "kernels/mean/mean.h"

namespace im2fit {
DepthFusion::DepthFusion(int width, int height)
    : width_(width),
      height_(height),
      sum_mm_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      count_(sum_mm_.size()),
      depth_q4_(sum_mm_.size()),
      mask_(sum_mm_.size()) {}

void DepthFusion::reset() {
  if (frame_count_ == 0) return;  // all zero still
  frame_count_ = 0;
  std::fill(sum_mm_.begin(), sum_mm_.end(), 0U);
  std::fill(count_.begin(), count_.end(), std::uint16_t{0});
}

void DepthFusion::add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max) {
  const int left = std::max(0, u_min);
  const int count = std::min(width_ - 1, u_max) - left + 1;
  for (int v = std::max(0, v_min); count > 0 && v <= std::min(height_ - 1, v_max); ++v) {
    const auto at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(left);
    average(depth.row(v) + left, mask.row(v) + left, count, sum_mm_.data() + at, count_.data() + at);
  }
  ++frame_count_;
}

void DepthFusion::finish() {
  mean(sum_mm_.data(), count_.data(), width_ * height_, std::max(1, (frame_count_ + 1) / 2), depth_q4_.data(),
       mask_.data());
}

}  // namespace im2fit
