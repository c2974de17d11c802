// SPDX-License-Identifier: Apache-2.0
// The person's box, one value for each block of step x step pixels, and its moments.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit::joints {

struct DownsampleBox {
  DepthView depth;
  MaskView mask;                 // of depth's size
  int step = 1;                  // px
  int u_first = 0, v_first = 0;  // of the box, in blocks
  int width = 0, height = 0;     // blocks; each begins inside the picture. width <= kDownsampleWidthMax
};
inline constexpr int kDownsampleWidthMax = kImageSideMax;

struct DownsampleMoments {
  std::int64_t count = 0;  // blocks with a value
  std::int64_t z = 0;      // sum of the values; u and v below are counted from the box's corner
  std::int64_t uz = 0;
  std::int64_t vz = 0;
};

// out: width * height values: of each block the first pixel with mask and depth, row by row, 0 without one. A choice
// and no mean: no depth arises between two limbs. Exact. No allocation, thread-safe.
using DownsampleBoxFunction = void(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments);
DownsampleBoxFunction downsample_box_portable, downsample_box_neon, downsample_box_avx2, downsample_box;

inline constexpr KernelVariant<DownsampleBoxFunction> kDownsampleBoxKernels[] = {
    IM2FIT_PORTABLE(downsample_box) IM2FIT_NEON(downsample_box) IM2FIT_AVX2(downsample_box)};

}  // namespace im2fit::joints
