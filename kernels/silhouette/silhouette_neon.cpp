// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/silhouette/silhouette_rows.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;
constexpr int kBlock = 32;  // pixels: a lane takes 2 x 32767 x 2047 for eight of them, and far less than 2^32 a block

std::uint64_t sum_of(uint64x2_t v) {
  return vgetq_lane_u64(v, 0) + vgetq_lane_u64(v, 1);
}

using Row = SilhouetteRow;

int first_set(std::uint64_t bytes) {
  return __builtin_ctzll(bytes) / 8;
}
int last_set(std::uint64_t bytes) {
  return 7 - __builtin_clzll(bytes) / 8;
}

// Sums of a row so far; `row` has its box.
struct Sums {
  uint32x4_t z = vdupq_n_u32(0), uz = vdupq_n_u32(0);
  uint64x2_t uz_wide = vdupq_n_u64(0);
  uint16x8_t count = vdupq_n_u16(0);
};

void eight(const std::uint16_t* z, const std::uint8_t* m, int u, Sums& sums, Row& row) {
  const uint8x8_t mask = vld1_u8(m + u);
  const std::uint64_t bytes = vget_lane_u64(vreinterpret_u64_u8(mask), 0);
  if (bytes == 0) return;
  const std::uint16_t up[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
  const uint16x8_t wide = vreinterpretq_u16_s16(vmovl_s8(vreinterpret_s8_u8(mask)));
  const uint16x8_t seen = vandq_u16(vld1q_u16(z + u), wide);
  const uint16x8_t columns = vaddq_u16(vld1q_u16(up), vdupq_n_u16(static_cast<std::uint16_t>(u)));
  sums.z = vpadalq_u16(sums.z, seen);
  sums.uz = vmlal_u16(sums.uz, vget_low_u16(seen), vget_low_u16(columns));
  sums.uz = vmlal_u16(sums.uz, vget_high_u16(seen), vget_high_u16(columns));
  sums.count = vsubq_u16(sums.count, wide);  // less -1
  if (row.last < 0) row.first = u + first_set(bytes);
  row.last = u + last_set(bytes);
}

Row measure_row(const std::uint16_t* z, const std::uint8_t* m, int width) {
  Row row;
  Sums sums;
  int u = 0;
  for (; u + kBlock <= width; u += kBlock) {
    const uint8x16_t any = vorrq_u8(vld1q_u8(m + u), vld1q_u8(m + u + 16));
    const uint64x2_t words = vreinterpretq_u64_u8(any);
    if ((vgetq_lane_u64(words, 0) | vgetq_lane_u64(words, 1)) == 0) continue;
    for (int i = 0; i < kBlock; i += kLanes) eight(z, m, u + i, sums, row);
    sums.uz_wide = vpadalq_u32(sums.uz_wide, sums.uz);
    sums.uz = vdupq_n_u32(0);
  }
  for (; u + kLanes <= width; u += kLanes) eight(z, m, u, sums, row);
  if (row.last >= 0) {
    row.z = sum_of(vpaddlq_u32(sums.z));
    row.uz = sum_of(vpadalq_u32(sums.uz_wide, sums.uz));
    row.count = static_cast<int>(sum_of(vpaddlq_u32(vpaddlq_u16(sums.count))));
  }
  for (; u < width; ++u) {
    if (m[u] == 0) continue;
    if (row.last < 0) row.first = u;
    row.last = u;
    ++row.count;
    row.z += z[u];
    row.uz += static_cast<std::uint64_t>(u) * z[u];
  }
  return row;
}

}  // namespace

void silhouette_neon(DepthView depth, MaskView mask, Silhouette& out) {
  out = silhouette_of_rows(depth, mask, measure_row);
}

}  // namespace im2fit
