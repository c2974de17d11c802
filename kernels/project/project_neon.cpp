// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/project/project.h"

namespace im2fit {
void project_neon(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                  std::int64_t* out) {
  for (int r = 0; r < row_count; ++r, weights += stride) {
    int64x2_t a = vdupq_n_s64(0), b = a;
    for (int i = 0; i < stride; i += 16) {
      const int16x8_t f = vld1q_s16(feature + i), g = vld1q_s16(feature + i + 8);
      const int16x8_t w = vld1q_s16(weights + i), x = vld1q_s16(weights + i + 8);
      // Two products a lane, then pairs of lanes into 64 bits.
      a = vpadalq_s32(a, vmlal_s16(vmull_s16(vget_low_s16(f), vget_low_s16(w)), vget_high_s16(f), vget_high_s16(w)));
      b = vpadalq_s32(b, vmlal_s16(vmull_s16(vget_low_s16(g), vget_low_s16(x)), vget_high_s16(g), vget_high_s16(x)));
    }
    const int64x2_t sum = vaddq_s64(a, b);
    out[r] = vgetq_lane_s64(sum, 0) + vgetq_lane_s64(sum, 1);
  }
}

}  // namespace im2fit
