// SPDX-License-Identifier: Apache-2.0
#include "kernels/joints/trees/walk.h"

namespace im2fit::joints {

void sum_leaves_portable(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                         std::int32_t* sum) {
  for_each_batch(splits, leaves, tree_count, pixels, [sum](const std::int8_t* const* found, int count) {
    // A batch of 16 fits 16 bits: half as many vectors as adding to `sum` leaf by leaf.
    std::int16_t batch[kLeafSize] = {};
    for (int t = 0; t < count; ++t) {
      const std::int8_t* __restrict leaf = found[t];
      for (int i = 0; i < kLeafSize; ++i) batch[i] = static_cast<std::int16_t>(batch[i] + leaf[i]);
    }
    for (int i = 0; i < kLeafSize; ++i) sum[i] += batch[i];
  });
}

void sum_leaves(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                std::int32_t* sum) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSumLeavesKernels);
  best(splits, leaves, tree_count, pixels, sum);
}

}  // namespace im2fit::joints
