// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/trees/walk.h"

namespace im2fit::joints {

void sum_leaves_neon(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                     int run_count, std::int32_t* sum) {
  for_each_batch(splits, leaves, tree_count, pixels, run_count, [&](const LeafBatch& batch) {
    for (int r = 0; r < run_count; ++r) {
      int16x8_t a = vdupq_n_s16(0), b = a, c = a, d = a;  // a batch fits 16 bits
      for (int t = 0; t < batch.count; ++t) {
        const std::int8_t* leaf = batch.leaf(t, r);
        const int8x16_t x = vld1q_s8(leaf), y = vld1q_s8(leaf + 16);
        a = vaddw_s8(a, vget_low_s8(x));
        b = vaddw_s8(b, vget_high_s8(x));
        c = vaddw_s8(c, vget_low_s8(y));
        d = vaddw_s8(d, vget_high_s8(y));
      }
      const int16x8_t all[4] = {a, b, c, d};
      for (int i = 0; i < 4; ++i) {
        std::int32_t* to = sum + r * kLeafSize + 8 * i;
        vst1q_s32(to, vaddw_s16(vld1q_s32(to), vget_low_s16(all[i])));
        vst1q_s32(to + 4, vaddw_s16(vld1q_s32(to + 4), vget_high_s16(all[i])));
      }
    }
  });
}

}  // namespace im2fit::joints
