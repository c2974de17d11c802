// SPDX-License-Identifier: Apache-2.0
// The person's outline, row by row: where it is seen, where its surface jumps, how much of it there is.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

// A pixel is seen where its mask and its depth are not 0.
struct ContourRow {
  std::int32_t first, last;        // outermost seen columns; width and -1 where none is
  std::uint32_t count;             // seen pixels
  std::uint32_t depth_sum;         // of them, 1/16 mm: 2048 * 65535 < 2^27
  std::uint64_t depth_square_sum;  // of them, 1/256 mm^2: 2048 * 65535^2 < 2^43
};

// Neighbours further apart in depth than this are two surfaces: 70 mm.
inline constexpr int kContourStepQ4 = 70 * 16;

// 64 pixels of a row to a word, the first in the lowest bit; bits past the row's end are 0.
constexpr std::size_t contour_words(int width) {
  return (static_cast<std::size_t>(width) + 63) / 64;
}

// For each of depth.height rows: rows[v], contour_words(width) words of `seen`, and as many of `steps`: bit u is set
// where pixels u - 1 and u are both seen and differ by kContourStepQ4 or more. `depth` in 1/16 mm; depth and mask of
// one size, up to 2048 wide, with any strides. All tiers the same integers. No allocation, thread-safe.
using ContourFunction = void(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows,
                             std::uint64_t* seen, std::uint64_t* steps);
ContourFunction contour_portable, contour_neon, contour_avx2, contour;

inline constexpr KernelVariant<ContourFunction> kContourKernels[] = {IM2FIT_PORTABLE(contour) IM2FIT_NEON(contour)
                                                                         IM2FIT_AVX2(contour)};

}  // namespace im2fit
