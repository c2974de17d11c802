// SPDX-License-Identifier: Apache-2.0
// Blocks of pixels summed up, front surface only.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kBlockSideMax = 16;                // px
inline constexpr std::uint32_t kSurfaceQ4 = 60U * 16U;  // deeper than this behind a block's front is another surface

struct BlockGrid {
  int step, columns, rows;
};

// For each block of step x step pixels, row by row: how many masked pixels with data lie no more than kSurfaceQ4
// behind the nearest of them, and the sum of their depths, both in 1/16 mm. `columns` and `rows` blocks from the
// upper left, step 1..16, picture no wider than kImageSideMax. No allocation, thread-safe. Integers only: all tiers
// agree bit for bit.
using BlocksFunction = void(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                            std::uint16_t* count);
BlocksFunction blocks_portable, blocks_neon, blocks_avx2;
BlocksFunction blocks;  // the fastest here

using BlocksKernel = KernelVariant<BlocksFunction>;
inline constexpr BlocksKernel kBlocksKernels[] = {IM2FIT_PORTABLE(blocks) IM2FIT_NEON(blocks) IM2FIT_AVX2(blocks)};

}  // namespace im2fit
