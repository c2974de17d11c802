// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/downsample/downsample_block.h"

namespace im2fit::joints {
namespace {

inline uint16x8_t masked(uint16x8_t depth, uint8x8_t mask) {
  // 0 or 255 in 8 bits to 0 or 65535 in 16.
  const int8x8_t on = vreinterpret_s8_u8(vtst_u8(mask, mask));
  return vandq_u16(depth, vreinterpretq_u16_s16(vmovl_s8(on)));
}
// a where it is not 0, else b.
inline uint16x8_t first_of(uint16x8_t a, uint16x8_t b) {
  return vbslq_u16(vtstq_u16(a, a), a, b);
}
inline uint16x8_t first_of_pair(const std::uint16_t* depth, const std::uint8_t* mask) {
  const uint16x8x2_t d = vld2q_u16(depth);
  const uint8x8x2_t m = vld2_u8(mask);
  return first_of(masked(d.val[0], m.val[0]), masked(d.val[1], m.val[1]));
}
inline uint16x8_t eight_of_two(const DownsampleRow& r, int u) {
  const std::uint16_t* depth = r.depth + std::ptrdiff_t{2} * u;
  const std::uint8_t* mask = r.mask + std::ptrdiff_t{2} * u;
  return first_of(first_of_pair(depth, mask), first_of_pair(depth + r.depth_stride, mask + r.mask_stride));
}
inline uint16x8_t eight_of_one(const DownsampleRow& r, int u) {
  return masked(vld1q_u16(r.depth + u), vld1_u8(r.mask + u));
}

template <class Eight>
inline int whole_row(const DownsampleRow& row, int count, std::uint16_t* out, RowSums& sums, Eight eight) {
  uint32x4_t once_low = vdupq_n_u32(0), once_high = once_low, again_low = once_low, again_high = once_low;
  uint16x8_t filled = vdupq_n_u16(0);
  int u = 0;
  for (; u + 8 <= count; u += 8) {
    const uint16x8_t z = eight(row, u);
    vst1q_u16(out + u, z);
    once_low = vaddw_u16(once_low, vget_low_u16(z));
    once_high = vaddw_u16(once_high, vget_high_u16(z));
    again_low = vaddq_u32(again_low, once_low);
    again_high = vaddq_u32(again_high, once_high);
    filled = vsubq_u16(filled, vtstq_u16(z, z));
  }
  std::uint32_t o[8], a[8];
  std::uint16_t f[8];
  vst1q_u32(o, once_low);
  vst1q_u32(o + 4, once_high);
  vst1q_u32(a, again_low);
  vst1q_u32(a + 4, again_high);
  vst1q_u16(f, filled);
  for (int l = 0; l < 8; ++l) sums.count += f[l];
  add_lanes(o, a, 8, u / 8, sums);
  return u;
}

}  // namespace

void downsample_box_neon(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments) {
  const int step = box.step;
  for_each_row(box, out, moments, [step](const DownsampleRow& row, int count, std::uint16_t* to, RowSums& sums) {
    if (step == 2) return whole_row(row, count, to, sums, eight_of_two);
    if (step == 1) return whole_row(row, count, to, sums, eight_of_one);
    return 0;
  });
}

}  // namespace im2fit::joints
