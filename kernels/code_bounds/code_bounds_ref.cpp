// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {

void code_bounds_ref(const std::int32_t* blocks, int block_count, const std::int32_t* place, int dimension_count,
                     std::uint32_t* out) {
  for (int box = 0; box < block_count * kBoxBlock; ++box) {
    const std::int32_t* block = blocks + std::int64_t{box / kBoxBlock} * dimension_count * 2 * kBoxBlock;
    double sum = 0;
    for (int d = 0; d < dimension_count; ++d, block += 2 * kBoxBlock) {
      const double low = block[box % kBoxBlock], high = block[kBoxBlock + box % kBoxBlock];
      const double gap = std::max({low - place[d], place[d] - high, 0.0});
      const double step = std::min(std::floor(gap / 16), double{kBoundGapMax});
      sum += step * step;
    }
    out[box] = static_cast<std::uint32_t>(sum);
  }
}

}  // namespace im2fit
