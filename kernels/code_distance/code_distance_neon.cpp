// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {
namespace {

struct Sums {
  int32x4_t low, high;
};

// Eight points, one dimension.
inline void add_squares(Sums& sum, int8x8_t codes, int16x8_t step, int16x8_t place) {
  const int16x8_t gap = vabdq_s16(vmulq_s16(vmovl_s8(codes), step), place);
  const int16x8_t counted = vminq_s16(gap, vdupq_n_s16(kCodeGapMax));
  sum.low = vmlal_s16(sum.low, vget_low_s16(counted), vget_low_s16(counted));
#ifdef __aarch64__
  sum.high = vmlal_high_s16(sum.high, counted, counted);
#else
  sum.high = vmlal_s16(sum.high, vget_high_s16(counted), vget_high_s16(counted));
#endif
}

inline std::int32_t smallest_of(int32x4_t v) {
#ifdef __aarch64__
  return vminvq_s32(v);
#else
  const int32x2_t two = vpmin_s32(vget_low_s32(v), vget_high_s32(v));
  return vget_lane_s32(vpmin_s32(two, two), 0);
#endif
}

}  // namespace

void code_distance_neon(const std::int8_t* blocks, int block_count, const CodeQuery& query, std::int32_t* out,
                        std::int32_t* least) {
  const int32x4_t zero = vdupq_n_s32(0);
  for (int b = 0; b < block_count; ++b, out += kCodeBlock) {
    Sums front = {zero, zero}, back = front;
    const std::int16_t *step = query.step.data(), *place = query.place.data();
    for (int p = 0; p < query.pair_count; ++p, step += 2, place += 2, blocks += 2 * kCodeBlock) {
      const int8x16x2_t codes = vld2q_s8(blocks);
      const int16x8_t s0 = vld1q_dup_s16(step), p0 = vld1q_dup_s16(place);
      const int16x8_t s1 = vld1q_dup_s16(step + 1), p1 = vld1q_dup_s16(place + 1);
      add_squares(front, vget_low_s8(codes.val[0]), s0, p0);
      add_squares(back, vget_high_s8(codes.val[0]), s0, p0);
      add_squares(front, vget_low_s8(codes.val[1]), s1, p1);
      add_squares(back, vget_high_s8(codes.val[1]), s1, p1);
    }
    vst1q_s32(out, front.low);
    vst1q_s32(out + 4, front.high);
    vst1q_s32(out + 8, back.low);
    vst1q_s32(out + 12, back.high);
    least[b] = smallest_of(vminq_s32(vminq_s32(front.low, front.high), vminq_s32(back.low, back.high)));
  }
}

}  // namespace im2fit
