// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/geodesic/geodesic.h"

namespace im2fit {
namespace {

// Parts of four steps.
inline int16x4_t parts4(const std::int32_t* a) {
  return vqmovn_s32(vsubq_s32(vld1q_s32(a + 1), vld1q_s32(a)));
}

// The root as a float, of numbers of at least 1. ARMv7 has no root: an estimate of 8 bits, doubled twice, is within
// 2^-21 of 1 / root, so the root within 0.03; AArch64's within 0.006. Nothing here is denormal.
inline float32x4_t float_root4(uint32x4_t square) {
  const float32x4_t number = vcvtq_f32_u32(square);
#ifdef __aarch64__
  return vsqrtq_f32(number);
#else
  float32x4_t inverse = vrsqrteq_f32(number);
  inverse = vmulq_f32(inverse, vrsqrtsq_f32(vmulq_f32(number, inverse), inverse));
  inverse = vmulq_f32(inverse, vrsqrtsq_f32(vmulq_f32(number, inverse), inverse));
  return vmulq_f32(number, inverse);
#endif
}

// The nearest whole number of the float root is off by one at most, which the exact remainder shows.
inline uint32x4_t nearest_root4(uint32x4_t square) {
  const float32x4_t near = float_root4(vmaxq_u32(square, vdupq_n_u32(1)));
  const int32x4_t root = vcvtq_s32_f32(vaddq_f32(near, vdupq_n_f32(0.5F)));
  const int32x4_t rest = vsubq_s32(vreinterpretq_s32_u32(square), vmulq_s32(root, root));
  const int32x4_t more = vreinterpretq_s32_u32(vcgtq_s32(rest, root));             // -1: one more
  const int32x4_t less = vreinterpretq_s32_u32(vcleq_s32(rest, vnegq_s32(root)));  // -1: one less
  return vreinterpretq_u32_s32(vaddq_s32(vsubq_s32(root, more), less));
}

inline uint32x4_t lengths4(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z) {
  const int16x4_t dx = parts4(x), dy = parts4(y), dz = parts4(z);
  // Squares are below 2^30 each: their sum wraps into the sign, which unsigned reading takes as what it is.
  const uint32x4_t xx = vreinterpretq_u32_s32(vmull_s16(dx, dx)), yy = vreinterpretq_u32_s32(vmull_s16(dy, dy)),
                   zz = vreinterpretq_u32_s32(vmull_s16(dz, dz));
  return nearest_root4(vaddq_u32(vaddq_u32(xx, yy), zz));
}

}  // namespace

std::uint32_t geodesic_neon(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count) {
  uint32x4_t sum = vdupq_n_u32(0);
  int i = 0;
  for (; i + 5 <= count; i += 4) sum = vaddq_u32(sum, lengths4(x + i, y + i, z + i));
  if (i + 1 < count) {
    // The last point again and again adds nothing.
    std::int32_t tail[3][5];
    for (int n = 0; n < 5; ++n) {
      const int from = i + n < count ? i + n : count - 1;
      tail[0][n] = x[from];
      tail[1][n] = y[from];
      tail[2][n] = z[from];
    }
    sum = vaddq_u32(sum, lengths4(tail[0], tail[1], tail[2]));
  }
  const uint64x2_t pairs = vpaddlq_u32(sum);
  return static_cast<std::uint32_t>(vgetq_lane_u64(pairs, 0) + vgetq_lane_u64(pairs, 1));
}

}  // namespace im2fit
