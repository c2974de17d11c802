// SPDX-License-Identifier: Apache-2.0
#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {

void code_bounds_portable(const std::int16_t* blocks, int block_count, const std::int16_t* place, int dimension_count,
                          std::int32_t* out) {
  for (int b = 0; b < block_count; ++b, out += kBoxBlock) {
    std::int32_t sum[kBoxBlock] = {};
    for (int d = 0; d < dimension_count; ++d, blocks += 2 * kBoxBlock) {
      for (int i = 0; i < kBoxBlock; ++i) {
        const std::int32_t below = blocks[i] - place[d], above = place[d] - blocks[kBoxBlock + i];
        std::int32_t gap = below > above ? below : above;
        gap = gap > 0 ? gap : 0;
        gap = gap < kCodeGapMax ? gap : kCodeGapMax;
        sum[i] += gap * gap;
      }
    }
    for (int i = 0; i < kBoxBlock; ++i) out[i] = sum[i];
  }
}

void code_bounds(const std::int16_t* blocks, int block_count, const std::int16_t* place, int dimension_count,
                 std::int32_t* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kCodeBoundsKernels);
  best(blocks, block_count, place, dimension_count, out);
}

}  // namespace im2fit
