// SPDX-License-Identifier: Apache-2.0
// A cell of 4 x 4 pixels is two registers. Cells of other sizes are copied to such blocks and back. The limit's
// floats are 0 or at least 2.85e-6: ARMv7's NEON, which knows no denormals, meets none.
#include <arm_neon.h>

#include "kernels/membership/membership.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

// floor(40 + 1.5 (2.85e-6 z z)): a whole distance is above the limit when it is above this.
uint16x4_t limit_half(uint16x4_t z) {
  const float32x4_t f = vcvtq_f32_u32(vmovl_u16(z));
  const float32x4_t quantum = vmulq_f32(vmulq_f32(vdupq_n_f32(2.85e-6F), f), f);
  const float32x4_t all = vaddq_f32(vdupq_n_f32(40.0F), vmulq_f32(vdupq_n_f32(1.5F), quantum));
  return vqmovn_u32(vcvtq_u32_f32(all));
}
uint16x8_t limit(uint16x8_t z) {
  return vcombine_u16(limit_half(vget_low_u16(z)), limit_half(vget_high_u16(z)));
}

bool any(uint16x8_t v) {
  const uint16x4_t both = vorr_u16(vget_low_u16(v), vget_high_u16(v));
  return vget_lane_u64(vreinterpret_u64_u16(both), 0) != 0;
}

struct Around {
  std::uint16_t person[9], other[9];
  int person_count = 0, other_count = 0;
  std::uint16_t own = kNoSurface;
  bool interior = false;
};

void look_around(const MembershipCells& cells, int c, int r, Around& out) {
  const std::ptrdiff_t middle = std::ptrdiff_t{r} * cells.stride + c;
  out.person_count = out.other_count = 0;
  for (int dr = -1; dr <= 1; ++dr) {
    for (int dc = -1; dc <= 1; ++dc) {
      const std::ptrdiff_t at = middle + std::ptrdiff_t{dr} * cells.stride + dc;
      const std::uint16_t p = cells.person[at], o = cells.other[at];
      if (p != kNoSurface) out.person[out.person_count++] = p;
      if (o != kNoSurface) out.other[out.other_count++] = o;
    }
  }
  out.own = cells.person[middle];
  out.interior = out.other_count == 0 && out.own != kNoSurface;
}

// All ones in the lanes that belong.
uint16x8_t judge(const Around& around, uint16x8_t z) {
  const uint16x8_t seen = vcltq_u16(vsubq_u16(z, vdupq_n_u16(1)), vdupq_n_u16(10000));
  uint16x8_t inside = vdupq_n_u16(0);
  if (around.interior) {
    inside = vcltq_u16(vabdq_u16(z, vdupq_n_u16(around.own)), vdupq_n_u16(40));
    if (!any(vbicq_u16(seen, inside))) return seen;
  }
  uint16x8_t person = vdupq_n_u16(65535), other = person;
  for (int i = 0; i < around.person_count; ++i)
    person = vminq_u16(person, vabdq_u16(z, vdupq_n_u16(around.person[i])));
  for (int i = 0; i < around.other_count; ++i) other = vminq_u16(other, vabdq_u16(z, vdupq_n_u16(around.other[i])));
  const uint16x8_t near = vandq_u16(vcleq_u16(person, limit(z)), vcleq_u16(person, other));
  return vandq_u16(seen, vorrq_u16(inside, near));
}

void two_rows_of_4(const Around& around, const std::uint16_t* z, std::ptrdiff_t z_stride, std::uint8_t* out,
                   std::ptrdiff_t out_stride) {
  const uint8x8_t bytes = vmovn_u16(judge(around, vcombine_u16(vld1_u16(z), vld1_u16(z + z_stride))));
  const std::uint64_t both = vget_lane_u64(vreinterpret_u64_u8(bytes), 0);
  const auto upper = static_cast<std::uint32_t>(both), lower = static_cast<std::uint32_t>(both >> 32);
  __builtin_memcpy(out, &upper, sizeof upper);
  __builtin_memcpy(out + out_stride, &lower, sizeof lower);
}

void row_of_any(const Around& around, const std::uint16_t* z, int count, std::uint8_t* out) {
  for (int first = 0; first < count; first += kLanes) {
    const int n = count - first < kLanes ? count - first : kLanes;
    std::uint16_t block[kLanes] = {};
    for (int i = 0; i < n; ++i) block[i] = z[first + i];
    vst1q_u16(block, judge(around, vld1q_u16(block)));
    for (int i = 0; i < n; ++i) out[first + i] = static_cast<std::uint8_t>(block[i]);
  }
}

}  // namespace

void membership_neon(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count,
                     MaskImage mask) {
  Around around;
  for (int i = 0; i < count; ++i) {
    const int c = static_cast<int>(list[i] & 0xFFFF), r = static_cast<int>(list[i] >> 16);
    look_around(cells, c, r, around);
    const int u = c * cells.step, v = r * cells.step;
    const int wide = c + 1 == cells.width ? mask.width - u : cells.step;
    const int high = r + 1 == cells.height ? mask.height - v : cells.step;
    const std::uint16_t* z = depth.pixels + std::ptrdiff_t{v} * depth.stride + u;
    std::uint8_t* out = mask.pixels + std::ptrdiff_t{v} * mask.stride + u;
    if (wide == 4 && high == 4) {
      two_rows_of_4(around, z, depth.stride, out, mask.stride);
      two_rows_of_4(around, z + 2 * std::ptrdiff_t{depth.stride}, depth.stride, out + 2 * std::ptrdiff_t{mask.stride},
                    mask.stride);
    } else {
      for (int row = 0; row < high; ++row)
        row_of_any(around, z + std::ptrdiff_t{row} * depth.stride, wide, out + std::ptrdiff_t{row} * mask.stride);
    }
  }
}

}  // namespace im2fit
