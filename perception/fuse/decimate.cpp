// SPDX-License-Identifier: Apache-2.0
#include "perception/fuse/decimate.h"

#include <algorithm>
#include <array>
#include <limits>

#include "kernels/blocks/blocks.h"

namespace im2fit {
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
  const int needed = std::max(1, step_px * step_px / 3);
  std::array<std::uint32_t, kImageSideMax> sum_q4;
  std::array<std::uint16_t, kImageSideMax> count;
  std::size_t at = 0;
  for (int j = 0; j < grid.height; ++j) {
    const DepthView rows(depth_q4.row(j * step_px), depth_q4.width, step_px, depth_q4.stride);
    const MaskView mask_rows(mask.row(j * step_px), mask.width, step_px, mask.stride);
    blocks(rows, mask_rows, {step_px, grid.width, 1}, sum_q4.data(), count.data());
    for (int i = 0; i < grid.width; ++i, ++at) {
      const auto column = static_cast<std::size_t>(i);
      if (count[column] < needed) {
        x[at] = y[at] = z[at] = kNaN;
        continue;
      }
      const float depth = static_cast<float>(sum_q4[column]) / (16.0F * static_cast<float>(count[column]));
      const Vec3f p = unproject(grid, static_cast<float>(i), static_cast<float>(j), depth);
      x[at] = p.x;
      y[at] = p.y;
      z[at] = p.z;
    }
  }
}

}  // namespace im2fit
