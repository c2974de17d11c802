// SPDX-License-Identifier: Apache-2.0
#include "kernels/fuse/decimate.h"

#include <algorithm>
#include <limits>

namespace im2fit {
namespace {

constexpr std::uint32_t kSurfaceQ4 = 60U * 16U;  // deeper than this behind the block's front is another surface

struct Block {
  std::uint32_t sum_q4 = 0;
  std::uint32_t count = 0;
};

Block front_of_block(ImageView<const std::uint16_t> depth_q4, MaskView mask, int u0, int v0, int step) {
  std::uint32_t nearest = UINT32_MAX;
  for (int v = v0; v < v0 + step; ++v)
    for (int u = u0; u < u0 + step; ++u)
      if (mask.at(u, v) != 0 && depth_q4.at(u, v) > 0) nearest = std::min<std::uint32_t>(nearest, depth_q4.at(u, v));
  Block block;
  if (nearest == UINT32_MAX) return block;
  for (int v = v0; v < v0 + step; ++v) {
    for (int u = u0; u < u0 + step; ++u) {
      const std::uint32_t d = depth_q4.at(u, v);
      if (mask.at(u, v) == 0 || d == 0 || d > nearest + kSurfaceQ4) continue;
      block.sum_q4 += d;
      ++block.count;
    }
  }
  return block;
}

}  // namespace

int grid_step_px(const Intrinsics& intrinsics, float distance_mm) {
  if (!(distance_mm > 0)) return 1;
  return std::clamp(static_cast<int>(kGridSpacingMm * intrinsics.fx / distance_mm + 0.5F), 1, 16);
}

Intrinsics grid_intrinsics(const Intrinsics& k, int step_px) {
  const auto step = static_cast<float>(step_px);
  const float shift = 0.5F * (step - 1.0F);
  return {k.width / step_px, k.height / step_px,    k.fx / step,
          k.fy / step,       (k.cx - shift) / step, (k.cy - shift) / step};
}

void decimate(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& grid, int step_px,
              std::span<float> x, std::span<float> y, std::span<float> z) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const auto needed = static_cast<std::uint32_t>(std::max(1, step_px * step_px / 3));
  std::size_t at = 0;
  for (int j = 0; j < grid.height; ++j) {
    for (int i = 0; i < grid.width; ++i, ++at) {
      const Block block = front_of_block(depth_q4, mask, i * step_px, j * step_px, step_px);
      if (block.count < needed) {
        x[at] = y[at] = z[at] = kNaN;
        continue;
      }
      const float depth = static_cast<float>(block.sum_q4) / (16.0F * static_cast<float>(block.count));
      const Vec3f p = unproject(grid, static_cast<float>(i), static_cast<float>(j), depth);
      x[at] = p.x;
      y[at] = p.y;
      z[at] = p.z;
    }
  }
}

}  // namespace im2fit
