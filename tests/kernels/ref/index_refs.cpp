// SPDX-License-Identifier: Apache-2.0
// References of kernels over features, codes and trees.
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

// X' W X in long double.
void add_gram_ref(const double* rows, const double* weights, int count, int used, double* sums, double* products) {
  using Wide = long double;
  for (int i = 0; i < used; ++i) {
    Wide sum = 0;
    for (int n = 0; n < count; ++n) sum += Wide{weights[n]} * Wide{rows[n * kGramWidth + i]};
    sums[i] += static_cast<double>(sum);
    for (int j = 0; j <= i; ++j) {
      Wide product = 0;
      for (int n = 0; n < count; ++n)
        product += Wide{weights[n]} * Wide{rows[n * kGramWidth + i]} * Wide{rows[n * kGramWidth + j]};
      products[i * kGramWidth + j] += static_cast<double>(product);
    }
  }
}

void project_ref(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                 std::int64_t* out) {
  for (int r = 0; r < row_count; ++r) {
    // Whole numbers below 2^53 for up to 2^25 features: exact.
    double sum = 0;
    for (int i = 0; i < stride; ++i)
      sum += static_cast<double>(feature[i]) * static_cast<double>(weights[std::int64_t{r} * stride + i]);
    out[r] = static_cast<std::int64_t>(sum);
  }
}

void standardise_ref(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  constexpr double kMax = kStandardFeatureMax;
  for (int i = 0; i < count; ++i) {
    const double z = (double{feature[i]} - double{mean[i]}) * double{scale[i]};
    out[i] = static_cast<std::int16_t>(std::isnan(z) ? 0 : std::lround(4096 * std::clamp(z, -kMax, kMax)));
  }
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
