// SPDX-License-Identifier: Apache-2.0
#include "kernels/fuse/depth_fusion.h"

#include <algorithm>
#include <cstddef>

namespace im2fit {
namespace {

// Beyond this from the running mean a value belongs to another surface (a limb that moved, a flying pixel):
// five standard deviations of the sensor at 2.5 m.
constexpr std::uint32_t kOutlierMm = 50;
constexpr std::uint32_t kDepthMaxMm = 4095;  // what 1/16 mm in 16 bits can hold

}  // namespace

DepthFusion::DepthFusion(int width, int height)
    : width_(width),
      height_(height),
      sum_mm_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      count_(sum_mm_.size()),
      depth_q4_(sum_mm_.size()),
      mask_(sum_mm_.size()) {}

void DepthFusion::reset() {
  frame_count_ = 0;
  std::fill(sum_mm_.begin(), sum_mm_.end(), 0U);
  std::fill(count_.begin(), count_.end(), std::uint16_t{0});
}

void DepthFusion::add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max) {
  for (int v = std::max(0, v_min); v <= std::min(height_ - 1, v_max); ++v) {
    const std::uint16_t* d = depth.row(v);
    const std::uint8_t* m = mask.row(v);
    for (int u = std::max(0, u_min); u <= std::min(width_ - 1, u_max); ++u) {
      const std::uint32_t z = d[u];
      if (m[u] == 0 || z == 0 || z > kDepthMaxMm) continue;
      const auto at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
      const std::uint32_t n = count_[at];
      const std::uint32_t sum = sum_mm_[at];
      if (n > 0 && (z * n > sum + kOutlierMm * n || z * n + kOutlierMm * n < sum)) continue;
      sum_mm_[at] = sum + z;
      count_[at] = static_cast<std::uint16_t>(n + 1);
    }
  }
  ++frame_count_;
}

void DepthFusion::finish() {
  const auto needed = static_cast<std::uint16_t>(std::max(1, (frame_count_ + 1) / 2));
  for (std::size_t i = 0; i < sum_mm_.size(); ++i) {
    const std::uint32_t n = count_[i];
    const bool keep = n >= needed;
    mask_[i] = keep ? 255 : 0;
    depth_q4_[i] = keep ? static_cast<std::uint16_t>((sum_mm_[i] * 16U + n / 2U) / n) : std::uint16_t{0};
  }
}

}  // namespace im2fit
