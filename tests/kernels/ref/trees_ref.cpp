// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::joints {

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

}  // namespace im2fit::joints
