// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {
namespace {

struct Sums {  // of 8 points
  int32x4_t high[2], low[2];
};

inline void add(Sums& s, int16x8_t code, std::int16_t high, std::int16_t low) {
  s.high[0] = vmlal_n_s16(s.high[0], vget_low_s16(code), high);
  s.high[1] = vmlal_n_s16(s.high[1], vget_high_s16(code), high);
  s.low[0] = vmlal_n_s16(s.low[0], vget_low_s16(code), low);
  s.low[1] = vmlal_n_s16(s.low[1], vget_high_s16(code), low);
}
// norm + square - (2^16 high + 2 low), two points.
inline void store_two(int32x2_t high, int32x2_t low, const std::int64_t* norm, int64x2_t square, std::int64_t* out) {
  const int64x2_t n = vaddq_s64(vld1q_s64(norm), square);
  vst1q_s64(out, vsubq_s64(n, vaddq_s64(vshll_n_s32(high, 16), vshll_n_s32(low, 1))));
}
inline void store_eight(const Sums& s, const std::int64_t* norm, int64x2_t square, std::int64_t* out) {
  for (int i = 0; i < 2; ++i) {
    store_two(vget_low_s32(s.high[i]), vget_low_s32(s.low[i]), norm + 4 * i, square, out + 4 * i);
    store_two(vget_high_s32(s.high[i]), vget_high_s32(s.low[i]), norm + 4 * i + 2, square, out + 4 * i + 2);
  }
}

}  // namespace

void code_distance_neon(const std::int8_t* blocks, const std::int64_t* norm, int block_count, const CodeQuery& query,
                        std::int64_t* out) {
  const std::int16_t* high = reinterpret_cast<const std::int16_t*>(&query.high);
  const std::int16_t* low = reinterpret_cast<const std::int16_t*>(&query.low);
  const int64x2_t square = vdupq_n_s64(query.square);
  const int32x4_t zero = vdupq_n_s32(0);
  for (int b = 0; b < block_count; ++b, norm += kCodeBlock, out += kCodeBlock) {
    Sums front = {{zero, zero}, {zero, zero}}, back = front;
    for (int p = 0; p < query.pair_count; ++p, blocks += 2 * kCodeBlock) {
      const int8x16x2_t codes = vld2q_s8(blocks);
      for (int d = 0; d < 2; ++d) {
        add(front, vmovl_s8(vget_low_s8(codes.val[d])), high[2 * p + d], low[2 * p + d]);
        add(back, vmovl_s8(vget_high_s8(codes.val[d])), high[2 * p + d], low[2 * p + d]);
      }
    }
    store_eight(front, norm, square, out);
    store_eight(back, norm + 8, square, out + 8);
  }
}

}  // namespace im2fit
