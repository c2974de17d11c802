// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/moments/moments.h"

namespace im2fit {
namespace {

// Sums of degrees 0 to 2 stay in 32 bits for kBlock vectors of eight: 32 * 2 * 4095^2 < 2^30.1.
constexpr int kBlock = 32;
struct Low {
  int16x8_t count;
  int32x4_t x, y, xx, xy, yy;
};
struct High {
  int64x2_t sum[9];  // degrees 3 and 4, in the contract's order
};

inline std::int64_t sum32(int32x4_t a) {
  const int64x2_t pairs = vpaddlq_s32(a);
  return vgetq_lane_s64(pairs, 0) + vgetq_lane_s64(pairs, 1);
}

inline int64x2_t add_low_products(int64x2_t sum, int32x4_t a, int32x4_t b) {
  return vmlal_s32(sum, vget_low_s32(a), vget_low_s32(b));
}
inline int64x2_t add_high_products(int64x2_t sum, int32x4_t a, int32x4_t b) {
#ifdef __aarch64__
  return vmlal_high_s32(sum, a, b);
#else
  return vmlal_s32(sum, vget_high_s32(a), vget_high_s32(b));
#endif
}
inline void add_products(int64x2_t& sum, int32x4_t a, int32x4_t b) {
  sum = add_high_products(add_low_products(sum, a, b), a, b);
}

inline void add4(Low& l, High& h, int16x4_t x, int16x4_t y) {
  const int32x4_t xx = vmull_s16(x, x), xy = vmull_s16(x, y), yy = vmull_s16(y, y);
  const int32x4_t x32 = vmovl_s16(x), y32 = vmovl_s16(y);
  l.xx = vaddq_s32(l.xx, xx);
  l.xy = vaddq_s32(l.xy, xy);
  l.yy = vaddq_s32(l.yy, yy);
  add_products(h.sum[0], xx, x32);
  add_products(h.sum[1], xx, y32);
  add_products(h.sum[2], yy, x32);
  add_products(h.sum[3], yy, y32);
  add_products(h.sum[4], xx, xx);
  add_products(h.sum[5], xx, xy);
  add_products(h.sum[6], xx, yy);
  add_products(h.sum[7], xy, yy);
  add_products(h.sum[8], yy, yy);
}

inline void add8(Low& l, High& h, int16x8x2_t points, int16x8_t first_x, int16x8_t last_x) {
  const uint16x8_t in = vandq_u16(vcgeq_s16(points.val[0], first_x), vcleq_s16(points.val[0], last_x));
  const int16x8_t keep = vreinterpretq_s16_u16(in);
  const int16x8_t x = vandq_s16(points.val[0], keep), y = vandq_s16(points.val[1], keep);
  l.count = vsubq_s16(l.count, keep);
  l.x = vpadalq_s16(l.x, x);
  l.y = vpadalq_s16(l.y, y);
  add4(l, h, vget_low_s16(x), vget_low_s16(y));
  add4(l, h, vget_high_s16(x), vget_high_s16(y));
}

// Beyond every coordinate, so that narrowing the bounds changes nothing.
inline std::int16_t bound(int x) {
  return static_cast<std::int16_t>(x < -4096 ? -4096 : x > 4096 ? 4096 : x);
}

}  // namespace

void moments_neon(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums) {
  const int16x8_t first = vdupq_n_s16(bound(first_x)), last = vdupq_n_s16(bound(last_x));
  std::int64_t low[6] = {};
  High high;
  for (int i = 0; i < 9; ++i) high.sum[i] = vdupq_n_s64(0);
  for (int begin = 0; begin < count; begin += 8 * kBlock) {
    const int32x4_t zero = vdupq_n_s32(0);
    Low l = {vdupq_n_s16(0), zero, zero, zero, zero, zero};
    const int end = count - begin < 8 * kBlock ? count : begin + 8 * kBlock;
    int n = begin;
    for (; n + 8 <= end; n += 8)
      add8(l, high, vld2q_s16(reinterpret_cast<const std::int16_t*>(points + n)), first, last);
    if (n < end) {
      // Places past the end are (0, 0); only the count can tell them from points.
      std::int16_t tail[16] = {};
      for (int i = 0; i < end - n; ++i) {
        tail[2 * i] = points[n + i].x;
        tail[2 * i + 1] = points[n + i].y;
      }
      add8(l, high, vld2q_s16(tail), first, last);
      if (first_x <= 0 && last_x >= 0) low[0] -= 8 - (end - n);
    }
    const int32x4_t of_block[6] = {vpaddlq_s16(l.count), l.x, l.y, l.xx, l.xy, l.yy};
    for (int i = 0; i < 6; ++i) low[i] += sum32(of_block[i]);
  }
  for (int i = 0; i < 6; ++i) sums[i] = low[i];
  for (int i = 0; i < 9; ++i) sums[6 + i] = vgetq_lane_s64(high.sum[i], 0) + vgetq_lane_s64(high.sum[i], 1);
}

}  // namespace im2fit
