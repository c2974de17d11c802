// SPDX-License-Identifier: Apache-2.0
// The quotient comes from an approximate reciprocal, within 0.05 of the true one (16 bits of quotient; two Newton
// steps leave 2^-21), and is then put right by its remainder: exact, on ARMv7 as well, and nothing is denormal.
#include <arm_neon.h>

#include "kernels/mean/mean.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

uint32x4_t quotient(uint32x4_t a, uint32x4_t n) {
  const float32x4_t divisor = vcvtq_f32_u32(n);
  float32x4_t inverse = vrecpeq_f32(divisor);
  inverse = vmulq_f32(inverse, vrecpsq_f32(divisor, inverse));
  inverse = vmulq_f32(inverse, vrecpsq_f32(divisor, inverse));
  const uint32x4_t q = vcvtq_u32_f32(vmulq_f32(vcvtq_f32_u32(a), inverse));
  const int32x4_t rest = vreinterpretq_s32_u32(vmlsq_u32(a, q, n));
  const uint32x4_t too_small = vcgeq_s32(rest, vreinterpretq_s32_u32(n));
  const uint32x4_t too_large = vcltq_s32(rest, vdupq_n_s32(0));
  return vaddq_u32(vsubq_u32(q, too_small), too_large);
}

uint16x4_t four(uint32x4_t sum, uint16x4_t seen) {
  const uint32x4_t n = vmovl_u16(seen);
  return vmovn_u32(quotient(vaddq_u32(vshlq_n_u32(sum, 4), vshrq_n_u32(n, 1)), n));
}

void eight(const std::uint32_t* sum, const std::uint16_t* seen, uint16x8_t needed, std::uint16_t* depth_q4,
           std::uint8_t* mask) {
  const uint16x8_t n = vld1q_u16(seen);
  const uint16x8_t keep = vcgeq_u16(n, needed);
  const uint8x8_t bytes = vmovn_u16(keep);
  uint16x8_t q = vdupq_n_u16(0);
  if (vget_lane_u64(vreinterpret_u64_u8(bytes), 0) != 0)
    q = vandq_u16(keep,
                  vcombine_u16(four(vld1q_u32(sum), vget_low_u16(n)), four(vld1q_u32(sum + 4), vget_high_u16(n))));
  vst1q_u16(depth_q4, q);
  vst1_u8(mask, bytes);
}

}  // namespace

void mean_neon(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed, std::uint16_t* depth_q4,
               std::uint8_t* mask) {
  const uint16x8_t least = vdupq_n_u16(static_cast<std::uint16_t>(needed));
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) eight(sum + i, seen + i, least, depth_q4 + i, mask + i);
  mean_portable(sum + i, seen + i, count - i, needed, depth_q4 + i, mask + i);
}

}  // namespace im2fit
