// SPDX-License-Identifier: Apache-2.0
#include "kernels/joints/trees/walk.h"

namespace im2fit::joints {

void sum_leaves_portable(const Split* splits, const std::int16_t* leaves, int tree_count, const std::int16_t* pixels,
                         std::int32_t* sum) {
  for_each_batch(splits, leaves, tree_count, pixels, [sum](const std::int16_t* const* found, int count) {
    // Two loops of fixed length: whole vectors, then the rest, so that plain -O2 vectorises the first.
    constexpr int kWhole = kShapeSize / 8 * 8;
    for (int t = 0; t < count; ++t) {
      const std::int16_t* __restrict leaf = found[t];
      std::int32_t* __restrict out = sum;
      for (int i = 0; i < kWhole; ++i) out[i] += leaf[i];
      for (int i = kWhole; i < kShapeSize; ++i) out[i] += leaf[i];
    }
  });
}

void sum_leaves(const Split* splits, const std::int16_t* leaves, int tree_count, const std::int16_t* pixels,
                std::int32_t* sum) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSumLeavesKernels);
  best(splits, leaves, tree_count, pixels, sum);
}

}  // namespace im2fit::joints
