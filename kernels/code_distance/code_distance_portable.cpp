// SPDX-License-Identifier: Apache-2.0
#include <cassert>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {

CodeQuery::CodeQuery(const std::int32_t* steps, const std::int32_t* at, int dimension_count)
    : pair_count((dimension_count + 1) / 2) {
  assert(dimension_count <= kCodeDimensionMax);
  for (std::size_t j = 0; j < static_cast<std::size_t>(dimension_count); ++j) {
    assert(steps[j] >= 0 && steps[j] <= kCodeStepMax);
    step[j] = steps[j];
    place[j] = at[j] > kCodePlaceMax ? kCodePlaceMax : at[j] < -kCodePlaceMax ? -kCodePlaceMax : at[j];
    const std::int32_t whole = step[j] * place[j];
    std::int16_t* high = &weight[j / 2 * 4 + j % 2];
    high[0] = static_cast<std::int16_t>(whole >> 15);
    high[2] = static_cast<std::int16_t>(whole & 0x7FFF);
    square += std::int64_t{place[j]} * place[j];
  }
}

void code_distance_portable(const std::int8_t* blocks, const std::int64_t* norm, int block_count,
                            const CodeQuery& query, std::int64_t* out) {
  for (int b = 0; b < block_count; ++b, norm += kCodeBlock, out += kCodeBlock) {
    // At most 16 products of 8 by 16 bits: below 2^27.
    std::int32_t high[kCodeBlock] = {}, low[kCodeBlock] = {};
    const std::int16_t* w = query.weight.data();
    for (int pair = 0; pair < query.pair_count; ++pair, w += 4, blocks += 2 * kCodeBlock) {
      for (int i = 0; i < kCodeBlock; ++i) {
        high[i] += blocks[2 * i] * w[0] + blocks[2 * i + 1] * w[1];
        low[i] += blocks[2 * i] * w[2] + blocks[2 * i + 1] * w[3];
      }
    }
    for (int i = 0; i < kCodeBlock; ++i)
      out[i] = norm[i] + query.square - (std::int64_t{high[i]} * 65536 + std::int64_t{low[i]} * 2);
  }
}

void code_distance(const std::int8_t* blocks, const std::int64_t* norm, int block_count, const CodeQuery& query,
                   std::int64_t* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kCodeDistanceKernels);
  best(blocks, norm, block_count, query, out);
}

}  // namespace im2fit
