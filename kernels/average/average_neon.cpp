// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/average/average.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

// Four pixels: all ones where their depth is to be added.
uint32x4_t near_mean(uint16x4_t z, uint16x4_t n, uint32x4_t sum) {
  const uint32x4_t away = vabdq_u32(vmull_u16(z, n), sum);
  return vcleq_u32(away, vmull_n_u16(n, kOutlierMm));
}

void eight_pixels(const std::uint16_t* depth, const std::uint8_t* mask, std::uint32_t* sum, std::uint16_t* seen) {
  const uint8x8_t m = vld1_u8(mask);
  if (vget_lane_u64(vreinterpret_u64_u8(m), 0) == 0) return;
  const uint16x8_t z = vld1q_u16(depth);
  const uint16x8_t n = vld1q_u16(seen);
  const uint32x4_t low = vld1q_u32(sum), high = vld1q_u32(sum + 4);
  const uint16x8_t inside = vreinterpretq_u16_s16(vmovl_s8(vreinterpret_s8_u8(m)));
  const uint16x8_t good = vcltq_u16(vsubq_u16(z, vdupq_n_u16(1)), vdupq_n_u16(kFusedDepthMaxMm));
  const uint16x8_t near = vcombine_u16(vmovn_u32(near_mean(vget_low_u16(z), vget_low_u16(n), low)),
                                       vmovn_u32(near_mean(vget_high_u16(z), vget_high_u16(n), high)));
  const uint16x8_t add = vandq_u16(vandq_u16(inside, good), near);
  const uint16x8_t more = vandq_u16(z, add);
  vst1q_u32(sum, vaddw_u16(low, vget_low_u16(more)));
  vst1q_u32(sum + 4, vaddw_u16(high, vget_high_u16(more)));
  vst1q_u16(seen, vsubq_u16(n, add));
}

}  // namespace

void average_neon(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
                  std::uint16_t* seen) {
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) eight_pixels(depth + i, mask + i, sum + i, seen + i);
  average_portable(depth + i, mask + i, count - i, sum + i, seen + i);
}

}  // namespace im2fit
