// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {
namespace {

template <int kLane>
inline int32x4_t add_low(int32x4_t sum, int16x8_t code, int16x4_t weight) {
  return vmlal_lane_s16(sum, vget_low_s16(code), weight, kLane);
}
template <int kLane>
inline int32x4_t add_high(int32x4_t sum, int16x8_t code, int16x4_t weight) {
#ifdef __aarch64__
  return vmlal_high_lane_s16(sum, code, weight, kLane);
#else
  return vmlal_lane_s16(sum, vget_high_s16(code), weight, kLane);
#endif
}

// norm + square - (2^16 high + 2 low), four points.
inline void store_four(int32x4_t high, int32x4_t low, const std::int64_t* norm, int64x2_t square, std::int64_t* out) {
  int64x2_t a = vaddq_s64(vld1q_s64(norm), square), b = vaddq_s64(vld1q_s64(norm + 2), square);
  a = vmlsl_n_s32(vmlsl_n_s32(a, vget_low_s32(high), 65536), vget_low_s32(low), 2);
  b = vmlsl_n_s32(vmlsl_n_s32(b, vget_high_s32(high), 65536), vget_high_s32(low), 2);
  vst1q_s64(out, a);
  vst1q_s64(out + 2, b);
}

}  // namespace

void code_distance_neon(const std::int8_t* blocks, const std::int64_t* norm, int block_count, const CodeQuery& query,
                        std::int64_t* out) {
  const int64x2_t square = vdupq_n_s64(query.square);
  const int32x4_t zero = vdupq_n_s32(0);
  for (int b = 0; b < block_count; ++b, norm += kCodeBlock, out += kCodeBlock) {
    int32x4_t h0 = zero, h1 = zero, h2 = zero, h3 = zero, l0 = zero, l1 = zero, l2 = zero, l3 = zero;
    const std::int16_t* weight = reinterpret_cast<const std::int16_t*>(&query.weight);
    for (int p = 0; p < query.pair_count; ++p, weight += 4, blocks += 2 * kCodeBlock) {
      const int8x16x2_t codes = vld2q_s8(blocks);
      const int16x4_t w = vld1_s16(weight);
      const int16x8_t front0 = vmovl_s8(vget_low_s8(codes.val[0])), back0 = vmovl_s8(vget_high_s8(codes.val[0]));
      const int16x8_t front1 = vmovl_s8(vget_low_s8(codes.val[1])), back1 = vmovl_s8(vget_high_s8(codes.val[1]));
      h0 = add_low<0>(h0, front0, w);
      l0 = add_low<2>(l0, front0, w);
      h1 = add_high<0>(h1, front0, w);
      l1 = add_high<2>(l1, front0, w);
      h2 = add_low<0>(h2, back0, w);
      l2 = add_low<2>(l2, back0, w);
      h3 = add_high<0>(h3, back0, w);
      l3 = add_high<2>(l3, back0, w);
      h0 = add_low<1>(h0, front1, w);
      l0 = add_low<3>(l0, front1, w);
      h1 = add_high<1>(h1, front1, w);
      l1 = add_high<3>(l1, front1, w);
      h2 = add_low<1>(h2, back1, w);
      l2 = add_low<3>(l2, back1, w);
      h3 = add_high<1>(h3, back1, w);
      l3 = add_high<3>(l3, back1, w);
    }
    store_four(h0, l0, norm, square, out);
    store_four(h1, l1, norm + 4, square, out + 4);
    store_four(h2, l2, norm + 8, square, out + 8);
    store_four(h3, l3, norm + 12, square, out + 12);
  }
}

}  // namespace im2fit
