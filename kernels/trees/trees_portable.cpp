// SPDX-License-Identifier: Apache-2.0
#include "kernels/trees/walk.h"

namespace im2fit::joints {

void sum_leaves_portable(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                         int run_count, std::int32_t* sum) {
  for_each_batch(splits, leaves, tree_count, pixels, run_count, [&](const LeafBatch& batch) {
    for (int r = 0; r < run_count; ++r) {
      // A batch of 16 fits 16 bits: half as many vectors as adding to `sum` leaf by leaf.
      std::int16_t leaves_of_run[kLeafSize] = {};
      for (int t = 0; t < batch.count; ++t) {
        const std::int8_t* __restrict leaf = batch.leaf(t, r);
        for (int i = 0; i < kLeafSize; ++i) leaves_of_run[i] = static_cast<std::int16_t>(leaves_of_run[i] + leaf[i]);
      }
      for (int i = 0; i < kLeafSize; ++i) sum[r * kLeafSize + i] += leaves_of_run[i];
    }
  });
}

void sum_leaves(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                int run_count, std::int32_t* sum) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSumLeavesKernels);
  best(splits, leaves, tree_count, pixels, run_count, sum);
}

}  // namespace im2fit::joints
