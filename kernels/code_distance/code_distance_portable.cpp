// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cassert>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {

CodeQuery::CodeQuery(const std::int32_t* steps, const std::int32_t* at, int dimension_count)
    : pair_count((dimension_count + 1) / 2) {
  assert(dimension_count <= kCodeDimensionMax);
  for (std::size_t j = 0; j < static_cast<std::size_t>(dimension_count); ++j) {
    assert(steps[j] >= 0 && steps[j] <= kCodeStepMax);
    step[j] = static_cast<std::int16_t>(steps[j]);
    place[j] = static_cast<std::int16_t>(std::clamp(at[j], -kCodePlaceMax, kCodePlaceMax));
  }
}

void code_distance_portable(const std::int8_t* blocks, int block_count, const CodeQuery& query, std::int32_t* out,
                            std::int32_t* least) {
  // A copy the stores to `out` cannot change.
  const auto step = query.step, place = query.place;
  const auto square_of = [](std::int32_t code, std::int32_t s, std::int32_t p) {
    const std::int32_t gap = code * s - p, length = gap < 0 ? -gap : gap;
    const std::int32_t counted = length < kCodeGapMax ? length : kCodeGapMax;
    return counted * counted;
  };
  for (int b = 0; b < block_count; ++b, out += kCodeBlock) {
    std::int32_t sum[kCodeBlock] = {};
    for (std::size_t j = 0; j < 2 * static_cast<std::size_t>(query.pair_count); j += 2, blocks += 2 * kCodeBlock)
      for (int i = 0; i < kCodeBlock; ++i)
        sum[i] +=
            square_of(blocks[2 * i], step[j], place[j]) + square_of(blocks[2 * i + 1], step[j + 1], place[j + 1]);
    std::int32_t smallest = sum[0];
    for (int i = 0; i < kCodeBlock; ++i) {
      out[i] = sum[i];
      smallest = sum[i] < smallest ? sum[i] : smallest;
    }
    least[b] = smallest;
  }
}

void code_distance(const std::int8_t* blocks, int block_count, const CodeQuery& query, std::int32_t* out,
                   std::int32_t* least) {
  IM2FIT_CHOSEN_ONCE best = fastest(kCodeDistanceKernels);
  best(blocks, block_count, query, out, least);
}

}  // namespace im2fit
