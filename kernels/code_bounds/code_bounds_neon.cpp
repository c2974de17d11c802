// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {
namespace {

struct Sums {
  int32x4_t low, high;
};

// Eight boxes: the way from the place to the nearest value between the edges.
inline void add_gaps(Sums& sum, const std::int16_t* box, int16x8_t place) {
  const int16x8_t nearest = vminq_s16(vmaxq_s16(place, vld1q_s16(box)), vld1q_s16(box + kBoxBlock));
  const int16x8_t gap = vminq_s16(vabdq_s16(place, nearest), vdupq_n_s16(kCodeGapMax));
  sum.low = vmlal_s16(sum.low, vget_low_s16(gap), vget_low_s16(gap));
#ifdef __aarch64__
  sum.high = vmlal_high_s16(sum.high, gap, gap);
#else
  sum.high = vmlal_s16(sum.high, vget_high_s16(gap), vget_high_s16(gap));
#endif
}

}  // namespace

void code_bounds_neon(const std::int16_t* blocks, int block_count, const std::int16_t* place, int dimension_count,
                      std::int32_t* out) {
  const int32x4_t zero = vdupq_n_s32(0);
  for (int b = 0; b < block_count; ++b, out += kBoxBlock) {
    Sums front = {zero, zero}, back = front;
    for (int d = 0; d < dimension_count; ++d, blocks += 2 * kBoxBlock) {
      const int16x8_t p = vdupq_n_s16(place[d]);
      add_gaps(front, blocks, p);
      add_gaps(back, blocks + 8, p);
    }
    vst1q_s32(out, front.low);
    vst1q_s32(out + 4, front.high);
    vst1q_s32(out + 8, back.low);
    vst1q_s32(out + 12, back.high);
  }
}

}  // namespace im2fit
