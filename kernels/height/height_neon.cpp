// SPDX-License-Identifier: Apache-2.0
#include "kernels/height/height.h"
#include "kernels/rayform/rayform_neon.h"

namespace im2fit {
namespace {

struct RowConstants {
  int32x4_t up_row, side_row;
};

// Four pixels; bins beyond the last count nowhere: squares has one more for them.
inline int32x4_t scan4(const HeightScan& s, uint16x4_t depth, int u, const RowConstants& row, int32x4_t lowest,
                       std::uint64_t* squares) {
  const int32x4_t z = form_depth4(depth);
  const int32x4_t side = vaddq_s32(form_product4(s.side_columns + u, row.side_row, z), vdupq_n_s32(s.side_offset));
  const uint32x4_t counts =
      vandq_u32(vcgtq_s32(z, vdupq_n_s32(0)), vcltq_s32(vabsq_s32(side), vdupq_n_s32(s.side_max)));
  if (!any4(counts)) return lowest;
  const int32x4_t height = vaddq_s32(form_product4(s.up_columns + u, row.up_row, z), vdupq_n_s32(s.up_offset));
  // As unsigned numbers, bins below the first lie above the last.
  const uint32x4_t all = vreinterpretq_u32_s32(vshrq_n_s32(
      vsubq_s32(height, vdupq_n_s32(kHeightMinMm * (1 << CoordinateMm::kFractionBits))), kHeightBinShift));
  const uint32x4_t bin = vminq_u32(vornq_u32(all, counts), vdupq_n_u32(kHeightBins));
  const uint32x4_t square = vmull_u16(depth, depth);
  squares[vgetq_lane_u32(bin, 0)] += vgetq_lane_u32(square, 0);
  squares[vgetq_lane_u32(bin, 1)] += vgetq_lane_u32(square, 1);
  squares[vgetq_lane_u32(bin, 2)] += vgetq_lane_u32(square, 2);
  squares[vgetq_lane_u32(bin, 3)] += vgetq_lane_u32(square, 3);
  return vminq_s32(lowest, vbslq_s32(counts, height, vdupq_n_s32(kHeightNone)));
}

inline int32x4_t scan8(const HeightScan& s, const std::uint16_t* depth, const std::uint8_t* mask, int u,
                       const RowConstants& row, int32x4_t lowest, std::uint64_t* squares) {
  const uint16x8_t d = seen_depth8(depth, mask);
  lowest = scan4(s, vget_low_u16(d), u, row, lowest, squares);
  return scan4(s, vget_high_u16(d), u + 4, row, lowest, squares);
}

}  // namespace

std::int32_t height_neon(const HeightScan& s, std::uint64_t* out) {
  std::uint64_t squares[kHeightBins + 1] = {};
  int32x4_t lowest = vdupq_n_s32(kHeightNone);
  const int width = s.depth_q4.width;
  // A row's last pixels, fewer than eight, are copied into room for eight.
  const int whole = width & ~7;
  for (std::ptrdiff_t v = 0; v < s.depth_q4.height; ++v) {
    const std::uint16_t* depth = s.depth_q4.pixels + v * s.depth_q4.stride;
    const std::uint8_t* mask = s.mask.pixels + v * s.mask.stride;
    const RowConstants row = {vdupq_n_s32(s.up_rows[v]), vdupq_n_s32(s.side_rows[v])};
    for (int u = 0; u < whole; u += 8) {
      if (masked8(mask + u)) lowest = scan8(s, depth + u, mask + u, u, row, lowest, squares);
    }
    if (whole < width) {
      std::uint16_t depth_tail[8] = {};
      std::uint8_t mask_tail[8] = {};
      std::int32_t up_tail[8] = {}, side_tail[8] = {};
      for (int i = 0; i < width - whole; ++i) {
        depth_tail[i] = depth[whole + i];
        mask_tail[i] = mask[whole + i];
        up_tail[i] = s.up_columns[whole + i];
        side_tail[i] = s.side_columns[whole + i];
      }
      HeightScan tail = s;
      tail.up_columns = up_tail;
      tail.side_columns = side_tail;
      if (masked8(mask_tail)) lowest = scan8(tail, depth_tail, mask_tail, 0, row, lowest, squares);
    }
  }
  for (int i = 0; i < kHeightBins; ++i) out[i] = squares[i];
  std::int32_t lanes[4];
  vst1q_s32(lanes, lowest);
  std::int32_t result = lanes[0];
  for (int i = 1; i < 4; ++i) result = lanes[i] < result ? lanes[i] : result;
  return result;
}

}  // namespace im2fit
