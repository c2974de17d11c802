// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void code_bounds_ref(const std::int16_t* blocks, int block_count, const std::int16_t* place, int dimension_count,
                     std::int32_t* out) {
  for (int box = 0; box < block_count * kBoxBlock; ++box) {
    const std::int16_t* block = blocks + std::int64_t{box / kBoxBlock} * dimension_count * 2 * kBoxBlock;
    double sum = 0;
    for (int d = 0; d < dimension_count; ++d, block += 2 * kBoxBlock) {
      const double low = block[box % kBoxBlock], high = block[kBoxBlock + box % kBoxBlock];
      const double gap = std::min(std::max({low - place[d], place[d] - high, 0.0}), double{kCodeGapMax});
      sum += gap * gap;
    }
    out[box] = static_cast<std::int32_t>(sum);
  }
}

}  // namespace im2fit
