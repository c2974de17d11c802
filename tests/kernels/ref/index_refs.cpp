// SPDX-License-Identifier: Apache-2.0
// References of kernels over codes and trees.
#include <algorithm>
#include <cmath>

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

namespace joints {

void sum_leaves_ref(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                    int run_count, std::int32_t* sum) {
  for (int run = 0; run < run_count; ++run) {
    for (int t = 0; t < tree_count; ++t) {
      int node = 0;
      while (node < kSplitCount) {
        const Split& s = splits[t * kSplitCount + node];
        const int difference = pixels[s.a * kRunLanes + run] - pixels[s.b * kRunLanes + run];
        node = 2 * node + (difference > s.threshold ? 2 : 1);
      }
      const int leaf = t * kLeafCount + node - kSplitCount;
      for (int i = 0; i < kLeafSize; ++i) sum[run * kLeafSize + i] += leaves[leaf * kLeafSize + i];
    }
  }
}

}  // namespace joints

}  // namespace im2fit
