// SPDX-License-Identifier: Apache-2.0
// vqrdmulh is the product's definition. Integers below 2^31 over 2^10 are no denormals: ARMv7's NEON may convert
// them.
#include <arm_neon.h>

#include "kernels/unproject/unproject.h"

namespace im2fit {
namespace {

constexpr int kLanes = 4;

struct Shifts {
  int32x4_t to_depth, to_coordinate;
};

void four(uint16x4_t raw, int32x4_t column, int32x4_t row, const Shifts& shift, float* x, float* y, float* z) {
  const int32x4_t depth = vreinterpretq_s32_u32(vmovl_u16(raw));
  const int32x4_t product_depth = vshlq_s32(depth, shift.to_depth);
  const uint32x4_t none = vceqq_s32(depth, vdupq_n_s32(0));
  const float32x4_t nan = vreinterpretq_f32_u32(vdupq_n_u32(0x7FC00000));
  const auto store = [&](float* out, int32x4_t value) {
    vst1q_f32(out, vbslq_f32(none, nan, vcvtq_n_f32_s32(value, CoordinateMm::kFractionBits)));
  };
  store(x, vqrdmulhq_s32(column, product_depth));
  store(y, vqrdmulhq_s32(row, product_depth));
  store(z, vshlq_s32(depth, shift.to_coordinate));
}

}  // namespace

void unproject_neon(DepthView depth, int fraction_bits, const RayTable& rays, float* x, float* y, float* z) {
  const std::int32_t* columns = rays.column_raws();
  const std::int32_t* rows = rays.row_raws();
  const Shifts shift = {vdupq_n_s32(12 - fraction_bits), vdupq_n_s32(10 - fraction_bits)};
  for (int v = 0; v < depth.height; ++v) {
    const std::uint16_t* in = depth.pixels + std::ptrdiff_t{v} * depth.stride;
    const int32x4_t row = vdupq_n_s32(rows[v]);
    int u = 0;
    for (; u + kLanes <= depth.width; u += kLanes)
      four(vld1_u16(in + u), vld1q_s32(columns + u), row, shift, x + u, y + u, z + u);
    if (u < depth.width) {
      std::uint16_t raw[kLanes] = {};
      std::int32_t column[kLanes] = {};
      float out[3][kLanes];
      const int left = depth.width - u;
      for (int i = 0; i < left; ++i) {
        raw[i] = in[u + i];
        column[i] = columns[u + i];
      }
      four(vld1_u16(raw), vld1q_s32(column), row, shift, out[0], out[1], out[2]);
      for (int i = 0; i < left; ++i) {
        x[u + i] = out[0][i];
        y[u + i] = out[1][i];
        z[u + i] = out[2][i];
      }
    }
    x += depth.width;
    y += depth.width;
    z += depth.width;
  }
}

}  // namespace im2fit
