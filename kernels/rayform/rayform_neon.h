// SPDX-License-Identifier: Apache-2.0
// Four pixels' coordinates along an axis. For *_neon.cpp only.
#pragma once

#include <arm_neon.h>

#include <cstdint>

namespace im2fit {
namespace {

inline int32x4_t form_depth4(uint16x4_t depth_q4) {
  return vreinterpretq_s32_u32(vshll_n_u16(depth_q4, 9));  // kFormDepthShift
}

// vqrdmulh is the contract's rounding doubling high multiply itself.
inline int32x4_t form_product4(const std::int32_t* columns, int32x4_t row, int32x4_t depth) {
  return vqrdmulhq_s32(vaddq_s32(vld1q_s32(columns), row), depth);
}

inline bool masked8(const std::uint8_t* mask) {
  return vget_lane_u64(vreinterpret_u64_u8(vld1_u8(mask)), 0) != 0;
}

// Depths of eight pixels, 0 where they are not seen.
inline uint16x8_t seen_depth8(const std::uint16_t* depth, const std::uint8_t* mask) {
  const uint8x8_t m = vld1_u8(mask);
  const int16x8_t keep = vmovl_s8(vreinterpret_s8_u8(vtst_u8(m, m)));
  return vandq_u16(vld1q_u16(depth), vreinterpretq_u16_s16(keep));
}

// Whether any of four lanes is not zero.
inline bool any4(uint32x4_t a) {
  const uint32x2_t half = vorr_u32(vget_low_u32(a), vget_high_u32(a));
  return vget_lane_u64(vreinterpret_u64_u32(half), 0) != 0;
}

}  // namespace
}  // namespace im2fit
