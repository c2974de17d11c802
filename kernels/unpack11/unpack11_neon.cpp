// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/unpack11/unpack11.h"

namespace im2fit {
namespace {

uint32x4_t gather(uint8x16_t bytes, uint8x16_t order) {
#ifdef __aarch64__
  return vreinterpretq_u32_u8(vqtbl1q_u8(bytes, order));
#else
  const uint8x8x2_t table = {{vget_low_u8(bytes), vget_high_u8(bytes)}};
  return vreinterpretq_u32_u8(vcombine_u8(vtbl2_u8(table, vget_low_u8(order)), vtbl2_u8(table, vget_high_u8(order))));
#endif
}

}  // namespace

void unpack11_neon(const std::uint8_t* packed, int count, std::uint16_t* out) {
  // A value lies within three bytes: they go, the first on top, into 32 bits, and are shifted down. Indices beyond
  // the table give 0.
  static const std::uint8_t kOrder[32] = {255, 2, 1, 0, 255, 3, 2, 1, 255, 4,  3, 2, 255, 6,   5,  4,
                                          255, 7, 6, 5, 255, 8, 7, 6, 255, 10, 9, 8, 255, 255, 10, 9};
  static const std::int32_t kDown[8] = {-21, -18, -15, -20, -17, -14, -19, -16};
  const uint8x16_t order_low = vld1q_u8(kOrder), order_high = vld1q_u8(kOrder + 16);
  const int32x4_t down_low = vld1q_s32(kDown), down_high = vld1q_s32(kDown + 4);
  const uint16x8_t mask = vdupq_n_u16(0x7FF);
  // 16 bytes are read for 11: half a group more must follow.
  for (; count >= 8 + 4; count -= 8, packed += 11, out += 8) {
    const uint8x16_t bytes = vld1q_u8(packed);
    const uint16x4_t low = vmovn_u32(vshlq_u32(gather(bytes, order_low), down_low));
    const uint16x4_t high = vmovn_u32(vshlq_u32(gather(bytes, order_high), down_high));
    vst1q_u16(out, vandq_u16(vcombine_u16(low, high), mask));
  }
  unpack11_portable(packed, count, out);
}

}  // namespace im2fit
