// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/anchors/one_anchor.h"

namespace im2fit::joints {
namespace {

constexpr int kLanes = 4;

// Four indices below 16 as those of the bytes of floats.
uint8x16_t bytes_of(uint32x4_t index) {
  return vreinterpretq_u8_u32(vmlaq_n_u32(vdupq_n_u32(0x03020100), index, 0x04040404));
}
// A table of 16 floats in registers.
#if defined(__aarch64__)
struct Table {
  explicit Table(const float* from) {
    for (int i = 0; i < 4; ++i) bytes.val[i] = vreinterpretq_u8_f32(vld1q_f32(from + 4 * i));
  }
  float32x4_t look_up(uint8x16_t at) const { return vreinterpretq_f32_u8(vqtbl4q_u8(bytes, at)); }
  uint8x16x4_t bytes;
};
#else
struct Table {
  explicit Table(const float* from) {
    for (int i = 0; i < 4; ++i) {
      low.val[i] = vreinterpret_u8_f32(vld1_f32(from + 2 * i));
      high.val[i] = vreinterpret_u8_f32(vld1_f32(from + 8 + 2 * i));
    }
  }
  // An index outside leaves what the other half found.
  uint8x8_t half(uint8x8_t at) const { return vtbx4_u8(vtbl4_u8(low, at), high, vsub_u8(at, vdup_n_u8(32))); }
  float32x4_t look_up(uint8x16_t at) const {
    return vreinterpretq_f32_u8(vcombine_u8(half(vget_low_u8(at)), half(vget_high_u8(at))));
  }
  uint8x8x4_t low, high;
};
#endif

float32x4_t between(const Table& table, uint8x16_t from, uint8x16_t to, float32x4_t share) {
  const float32x4_t start = table.look_up(from);
  return vaddq_f32(start, vmulq_f32(vsubq_f32(table.look_up(to), start), share));
}
// Of the box, from a ray.
uint32x4_t pixel(float32x4_t ray, float f, float c, int first) {
  const float32x4_t at = vaddq_f32(vmulq_n_f32(ray, f), vdupq_n_f32(c));
  const int32x4_t shifted = vcvtq_s32_f32(vaddq_f32(at, vdupq_n_f32(kFloorShift)));
  return vreinterpretq_u32_s32(vsubq_s32(shifted, vdupq_n_s32(kFloorUnshift + first)));
}

struct Tables {
  explicit Tables(const AnchorJoints& joints) : x(joints.x), y(joints.y), inverse_z(joints.inverse_z) {}
  Table x, y, inverse_z;
};

void four(const Anchor* anchors, const Tables& tables, const AnchorBox& box, std::int16_t* out,
          std::ptrdiff_t out_step) {
  // dx, dy, both joints in one, share.
  const int16x4x4_t fields = vld4_s16(reinterpret_cast<const std::int16_t*>(anchors));
  const uint32x4_t joints = vmovl_u16(vreinterpret_u16_s16(fields.val[2]));
  const uint8x16_t from = bytes_of(vandq_u32(joints, vdupq_n_u32(0xFF))), to = bytes_of(vshrq_n_u32(joints, 8));
  const float32x4_t share = vmulq_n_f32(vcvtq_f32_s32(vmovl_s16(fields.val[3])), 1.0F / 256.0F);
  const float32x4_t dx = vcvtq_f32_s32(vmovl_s16(fields.val[0])), dy = vcvtq_f32_s32(vmovl_s16(fields.val[1]));
  const float32x4_t scale = between(tables.inverse_z, from, to, share);
  const float32x4_t rx = vmulq_f32(vaddq_f32(between(tables.x, from, to, share), dx), scale);
  const float32x4_t ry = vmulq_f32(vaddq_f32(between(tables.y, from, to, share), dy), scale);
  const uint32x4_t u = pixel(rx, box.fx, box.cx, box.u_first), v = pixel(ry, box.fy, box.cy, box.v_first);
  const uint32x4_t inside = vandq_u32(vcltq_u32(u, vdupq_n_u32(static_cast<std::uint32_t>(box.width))),
                                      vcltq_u32(v, vdupq_n_u32(static_cast<std::uint32_t>(box.height))));
  const uint32x4_t place = vandq_u32(vmlaq_n_u32(u, v, static_cast<std::uint32_t>(box.width)), inside);
  uint16x4_t depth = vdup_n_u16(0);
  depth = vld1_lane_u16(box.depth + vgetq_lane_u32(place, 0), depth, 0);
  depth = vld1_lane_u16(box.depth + vgetq_lane_u32(place, 1), depth, 1);
  depth = vld1_lane_u16(box.depth + vgetq_lane_u32(place, 2), depth, 2);
  depth = vld1_lane_u16(box.depth + vgetq_lane_u32(place, 3), depth, 3);
  const int32x4_t far = vdupq_n_s32(kAnchorFarMm);
  int32x4_t away = vsubq_s32(vreinterpretq_s32_u32(vmovl_u16(depth)), vdupq_n_s32(box.reference_mm));
  away = vmaxq_s32(vminq_s32(away, far), vdupq_n_s32(-kAnchorFarMm));
  const uint16x4_t seen = vand_u16(vmovn_u32(inside), vcgt_u16(depth, vdup_n_u16(0)));
  const int16x4_t result = vbsl_s16(seen, vmovn_s32(away), vdup_n_s16(kAnchorFarMm));
  vst1_lane_s16(out, result, 0);
  vst1_lane_s16(out + out_step, result, 1);
  vst1_lane_s16(out + 2 * out_step, result, 2);
  vst1_lane_s16(out + 3 * out_step, result, 3);
}

}  // namespace

void anchor_depths_neon(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                        std::int16_t* out, std::ptrdiff_t out_step) {
  const Tables tables(joints);
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) four(anchors + i, tables, box, out + i * out_step, out_step);
  for (; i < count; ++i) out[i * out_step] = anchor_depth(anchors[i], joints, box);
}

}  // namespace im2fit::joints
