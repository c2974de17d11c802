// SPDX-License-Identifier: Apache-2.0
#include "kernels/code_distance/code_distance.h"

namespace im2fit {

// By definition; needs no norms.
void code_distance_ref(const std::int8_t* blocks, const std::int64_t*, int block_count, const CodeQuery& query,
                       std::int64_t* out) {
  for (int point = 0; point < block_count * kCodeBlock; ++point) {
    const std::int8_t* block = blocks + std::int64_t{point / kCodeBlock} * query.pair_count * 2 * kCodeBlock;
    double sum = 0;  // whole numbers below 2^53: exact
    for (int j = 0; j < 2 * query.pair_count; ++j) {
      const int code = block[(j / 2 * kCodeBlock + point % kCodeBlock) * 2 + j % 2];
      const auto d = static_cast<std::size_t>(j);
      const auto difference = static_cast<double>(query.step[d] * code - query.place[d]);
      sum += difference * difference;
    }
    out[point] = static_cast<std::int64_t>(sum);
  }
}

}  // namespace im2fit
