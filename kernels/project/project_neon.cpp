// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/project/project.h"

namespace im2fit {
namespace {

// Two products a lane, then pairs of lanes into 64 bits.
inline int64x2_t add_eight(int64x2_t sum, int16x8_t f, const std::int16_t* w) {
  const int16x8_t x = vld1q_s16(w);
  const int32x4_t low = vmull_s16(vget_low_s16(f), vget_low_s16(x));
  return vpadalq_s32(sum, vmlal_s16(low, vget_high_s16(f), vget_high_s16(x)));
}
inline std::int64_t total(int64x2_t sum) {
  return vgetq_lane_s64(sum, 0) + vgetq_lane_s64(sum, 1);
}

}  // namespace

void project_neon(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                  std::int64_t* out) {
  const int64x2_t zero = vdupq_n_s64(0);
  int r = 0;
  // Four rows share what is read of the feature.
  for (; r + 4 <= row_count; r += 4, weights += std::int64_t{4} * stride) {
    const std::int16_t *first = weights, *second = first + stride, *third = second + stride, *fourth = third + stride;
    int64x2_t a = zero, b = zero, c = zero, d = zero;
    for (int i = 0; i < stride; i += 16) {
      const int16x8_t f = vld1q_s16(feature + i), g = vld1q_s16(feature + i + 8);
      a = add_eight(add_eight(a, f, first + i), g, first + i + 8);
      b = add_eight(add_eight(b, f, second + i), g, second + i + 8);
      c = add_eight(add_eight(c, f, third + i), g, third + i + 8);
      d = add_eight(add_eight(d, f, fourth + i), g, fourth + i + 8);
    }
    out[r] = total(a);
    out[r + 1] = total(b);
    out[r + 2] = total(c);
    out[r + 3] = total(d);
  }
  for (; r < row_count; ++r, weights += stride) {
    int64x2_t sum = zero;
    for (int i = 0; i < stride; i += 8) sum = add_eight(sum, vld1q_s16(feature + i), weights + i);
    out[r] = total(sum);
  }
}

}  // namespace im2fit
