// SPDX-License-Identifier: Apache-2.0
// A cell of 4 x 4 pixels at a time: a lane is a row of it, so that its pixels are added from left to right as the
// contract says. AArch64 only.
#if defined(__aarch64__)
#include <arm_neon.h>

#include "kernels/floor_sums/floor_sums.h"

namespace im2fit {
namespace {

struct Columns {
  float32x4_t z[4];
};

// Depths by column: lane i of z[j] is row i.
Columns columns_of(DepthView depth, const FloorCell& cell) {
  const std::uint16_t* p = depth.pixels + std::ptrdiff_t{cell.v} * depth.stride + cell.u;
  const std::ptrdiff_t stride = depth.stride;
  const uint16x8_t r02 = vcombine_u16(vld1_u16(p), vld1_u16(p + 2 * stride));
  const uint16x8_t r13 = vcombine_u16(vld1_u16(p + stride), vld1_u16(p + 3 * stride));
  // Rows 0 and 1 of columns 0 and 2 (1 and 3) in the lower half, rows 2 and 3 in the upper.
  const uint32x4_t even = vreinterpretq_u32_u16(vtrn1q_u16(r02, r13)),
                   odd = vreinterpretq_u32_u16(vtrn2q_u16(r02, r13));
  const uint16x8_t c0_2 = vreinterpretq_u16_u32(vuzp1q_u32(even, even)),
                   c2 = vreinterpretq_u16_u32(vuzp2q_u32(even, even));
  const uint16x8_t c1_3 = vreinterpretq_u16_u32(vuzp1q_u32(odd, odd)),
                   c3 = vreinterpretq_u16_u32(vuzp2q_u32(odd, odd));
  const auto wide = [](uint16x8_t c) { return vcvtq_f32_u32(vmovl_u16(vget_low_u16(c))); };
  return {{wide(c0_2), wide(c1_3), wide(c2), wide(c3)}};
}

float32x4_t where(uint32x4_t take, float32x4_t value) {
  return vreinterpretq_f32_u32(vandq_u32(take, vreinterpretq_u32_f32(value)));
}

struct Rows {
  float32x4_t n, x, xx, t, tx;
};

void sum_rows(DepthView depth, const FloorGate& gate, const FloorCell& cell, Rows& rows) {
  const Columns columns = columns_of(depth, cell);
  const float32x4_t row_up = vld1q_f32(gate.row_up + cell.v);
  float32x4_t n = vdupq_n_f32(0), x = n, xx = n, t = n, tx = n;
  for (int j = 0; j < 4; j += cell.stride) {
    const float32x4_t z = columns.z[j];
    const float32x4_t ray = vdupq_n_f32(gate.ray_x[cell.u + j]);
    const float32x4_t slope = vaddq_f32(vmulq_f32(vdupq_n_f32(gate.up_x), ray), row_up);
    const float32x4_t height = vaddq_f32(vmulq_f32(slope, z), vdupq_n_f32(gate.camera_height_mm));
    const float32x4_t limit = vaddq_f32(vdupq_n_f32(gate.flat_mm), vmulq_f32(vdupq_n_f32(gate.noise), z));
    const uint32x4_t seen = vandq_u32(vcgtq_f32(z, vdupq_n_f32(0)), vcleq_f32(z, vdupq_n_f32(10000)));
    const uint32x4_t take = vbicq_u32(seen, vcgtq_f32(vabsq_f32(height), limit));
    const float32x4_t inverse = vdivq_f32(vdupq_n_f32(1), z);
    n = vaddq_f32(n, where(take, vdupq_n_f32(1)));
    x = vaddq_f32(x, where(take, ray));
    xx = vaddq_f32(xx, where(take, vmulq_f32(ray, ray)));
    t = vaddq_f32(t, where(take, inverse));
    tx = vaddq_f32(tx, where(take, vmulq_f32(inverse, ray)));
  }
  rows = {n, x, xx, t, tx};
}

struct Sums {
  float64x2_t xx_xy = vdupq_n_f64(0), x_yy = vdupq_n_f64(0), y_1 = vdupq_n_f64(0), tx_ty = vdupq_n_f64(0),
              t_n = vdupq_n_f64(0);
};

// Two rows at a time, from half of each register; a lane is a row until the terms are paired.
struct TwoRows {
  float64x2_t n, x, xx, t, tx, y;
};

void add(Sums& sums, const TwoRows& rows, float64x2_t weight, bool both) {
  const float64x2_t x = vmulq_f64(weight, rows.x), xx = vmulq_f64(weight, rows.xx), n = vmulq_f64(weight, rows.n);
  const float64x2_t t = vmulq_f64(weight, rows.t), tx = vmulq_f64(weight, rows.tx), minus_t = vnegq_f64(t);
  const float64x2_t xy = vmulq_f64(x, rows.y), ty = vmulq_f64(t, rows.y);
  const float64x2_t y = vmulq_f64(n, rows.y), yy = vmulq_f64(y, rows.y);
  sums.xx_xy = vaddq_f64(sums.xx_xy, vzip1q_f64(xx, xy));
  sums.x_yy = vaddq_f64(sums.x_yy, vzip1q_f64(x, yy));
  sums.y_1 = vaddq_f64(sums.y_1, vzip1q_f64(y, n));
  sums.tx_ty = vsubq_f64(sums.tx_ty, vzip1q_f64(tx, ty));
  sums.t_n = vaddq_f64(sums.t_n, vzip1q_f64(minus_t, n));
  if (!both) return;
  sums.xx_xy = vaddq_f64(sums.xx_xy, vzip2q_f64(xx, xy));
  sums.x_yy = vaddq_f64(sums.x_yy, vzip2q_f64(x, yy));
  sums.y_1 = vaddq_f64(sums.y_1, vzip2q_f64(y, n));
  sums.tx_ty = vsubq_f64(sums.tx_ty, vzip2q_f64(tx, ty));
  sums.t_n = vaddq_f64(sums.t_n, vzip2q_f64(minus_t, n));
}

void add_cell(Sums& sums, const Rows& rows, const FloorGate& gate, const FloorCell& cell) {
  const float32x4_t y = vld1q_f32(gate.ray_y + cell.v);
  const float64x2_t weight = vdupq_n_f64(static_cast<double>(cell.weight));
  const auto low = [](float32x4_t v) { return vcvt_f64_f32(vget_low_f32(v)); };
  const bool both = cell.stride == 1;
  add(sums, {low(rows.n), low(rows.x), low(rows.xx), low(rows.t), low(rows.tx), low(y)}, weight, both);
  add(sums,
      {vcvt_high_f64_f32(rows.n), vcvt_high_f64_f32(rows.x), vcvt_high_f64_f32(rows.xx), vcvt_high_f64_f32(rows.t),
       vcvt_high_f64_f32(rows.tx), vcvt_high_f64_f32(y)},
      weight, both);
}

}  // namespace

void floor_sums_neon(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count,
                     PlaneSums& out) {
  if (step != 4) return floor_sums_portable(depth, step, gate, cells, count, out);
  Sums sums;
  Rows rows;
  for (int i = 0; i < count; ++i) {
    const FloorCell& cell = cells[i];
    sum_rows(depth, gate, cell, rows);
    add_cell(sums, rows, gate, cell);
  }
  out = {{vgetq_lane_f64(sums.xx_xy, 0), vgetq_lane_f64(sums.xx_xy, 1), vgetq_lane_f64(sums.x_yy, 0),
          vgetq_lane_f64(sums.x_yy, 1), vgetq_lane_f64(sums.y_1, 0), vgetq_lane_f64(sums.y_1, 1)},
         {vgetq_lane_f64(sums.tx_ty, 0), vgetq_lane_f64(sums.tx_ty, 1), vgetq_lane_f64(sums.t_n, 0)},
         vgetq_lane_f64(sums.t_n, 1)};
}

}  // namespace im2fit
#endif
