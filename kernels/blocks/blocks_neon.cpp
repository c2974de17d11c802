// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/blocks/blocks_lines.h"

namespace im2fit {
namespace {

uint16x8_t seen_at(const Rows& rows, int v, int u) {
  const int8x8_t m = vreinterpret_s8_u8(vld1_u8(rows.mask + v * rows.mask_stride + u));
  return vandq_u16(vld1q_u16(rows.depth + v * rows.depth_stride + u), vreinterpretq_u16_s16(vmovl_s8(m)));
}

bool find_nearest(const Rows& rows, int u, Lines& lines) {
  uint16x8_t nearest = vdupq_n_u16(65535);
  for (int v = 0; v < rows.step; ++v)
    nearest = vminq_u16(nearest, vsubq_u16(seen_at(rows, v, u), vdupq_n_u16(1)));  // 0 becomes 65535
  vst1q_u16(lines.nearest_less_1 + u, nearest);
  const uint16x4_t both = vand_u16(vget_low_u16(nearest), vget_high_u16(nearest));
  return vget_lane_u64(vreinterpret_u64_u16(both), 0) != ~std::uint64_t{0};
}

void sum_columns(const Rows& rows, int u, Lines& lines) {
  const uint16x8_t limit = vld1q_u16(lines.limit + u);
  uint32x4_t low = vdupq_n_u32(0), high = low;
  uint16x8_t count = vdupq_n_u16(0);
  for (int v = 0; v < rows.step; ++v) {
    const uint16x8_t seen = seen_at(rows, v, u);
    const uint16x8_t near = vcleq_u16(seen, limit);
    const uint16x8_t taken = vandq_u16(seen, near);
    low = vaddw_u16(low, vget_low_u16(taken));
    high = vaddw_u16(high, vget_high_u16(taken));
    count = vsubq_u16(count, vandq_u16(near, vtstq_u16(seen, seen)));
  }
  vst1q_u32(lines.sum + u, low);
  vst1q_u32(lines.sum + u + 4, high);
  vst1q_u16(lines.count + u, count);
}

}  // namespace

void blocks_neon(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                 std::uint16_t* count) {
  all_blocks<8>(depth_q4, mask, grid, sum_q4, count);
}

}  // namespace im2fit
