// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void code_distance_ref(const std::int8_t* blocks, int block_count, const CodeQuery& query, std::int32_t* out,
                       std::int32_t* least) {
  for (int point = 0; point < block_count * kCodeBlock; ++point) {
    const std::int8_t* block = blocks + std::int64_t{point / kCodeBlock} * query.pair_count * 2 * kCodeBlock;
    double sum = 0;  // whole numbers below 2^53: exact
    for (int j = 0; j < 2 * query.pair_count; ++j) {
      const int at = (j / 2 * kCodeBlock + point % kCodeBlock) * 2 + j % 2;
      const double code = block[at];
      const auto d = static_cast<std::size_t>(j);
      const double gap = std::min(std::abs(code * query.step[d] - query.place[d]), double{kCodeGapMax});
      sum += gap * gap;
    }
    out[point] = static_cast<std::int32_t>(sum);
  }
  for (int b = 0; b < block_count; ++b)
    least[b] = *std::min_element(out + b * kCodeBlock, out + (b + 1) * kCodeBlock);
}

}  // namespace im2fit
