// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/joints/trees/walk.h"

namespace im2fit::joints {

void sum_leaves_neon(const Split* splits, const std::int16_t* leaves, int tree_count, const std::int16_t* pixels,
                     std::int32_t* sum) {
  int32x4_t s[12];
  for (int i = 0; i < 12; ++i) s[i] = vdupq_n_s32(0);
  for_each_batch(splits, leaves, tree_count, pixels, [&s](const std::int16_t* const* found, int count) {
    // Two passes, so that the six sums of a pass stay in registers on ARMv7 too.
    for (int half = 0; half < 2; ++half) {
      int32x4_t* h = s + 6 * half;
      int32x4_t a = h[0], b = h[1], c = h[2], d = h[3], e = h[4], f = h[5];
      // Values 0..23; then 24..39 and 37..44: nothing past the leaf is read, 37..39 are dropped below.
      const int first = 24 * half, last = half == 0 ? 16 : 37;
      for (int t = 0; t < count; ++t) {
        const std::int16_t* leaf = found[t];
        const int16x8_t x = vld1q_s16(leaf + first), y = vld1q_s16(leaf + first + 8), z = vld1q_s16(leaf + last);
        a = vaddw_s16(a, vget_low_s16(x));
        b = vaddw_s16(b, vget_high_s16(x));
        c = vaddw_s16(c, vget_low_s16(y));
        d = vaddw_s16(d, vget_high_s16(y));
        e = vaddw_s16(e, vget_low_s16(z));
        f = vaddw_s16(f, vget_high_s16(z));
      }
      h[0] = a, h[1] = b, h[2] = c, h[3] = d, h[4] = e, h[5] = f;
    }
  });
  for (int i = 0; i < 10; ++i) vst1q_s32(sum + 4 * i, vaddq_s32(vld1q_s32(sum + 4 * i), s[i]));
  sum[40] += vgetq_lane_s32(s[10], 3);
  vst1q_s32(sum + 41, vaddq_s32(vld1q_s32(sum + 41), s[11]));
}

}  // namespace im2fit::joints
