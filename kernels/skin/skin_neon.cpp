// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/skin/skin.h"

// ARMv7 runs portable: see the header.
#ifdef __aarch64__
namespace im2fit {
namespace {

// p: x, y, z.
inline float32x4_t moved(const SkinMatrix* m, float32x4_t p) {
  const float* c = m->column[0];
  const float32x4_t xy = vaddq_f32(vmulq_laneq_f32(vld1q_f32(c), p, 0), vmulq_laneq_f32(vld1q_f32(c + 4), p, 1));
  return vaddq_f32(vaddq_f32(xy, vmulq_laneq_f32(vld1q_f32(c + 8), p, 2)), vld1q_f32(c + 12));
}
inline float32x4_t skinned(float32x4_t p, const SkinRecord* record, const SkinMatrix* matrices) {
  const std::uint8_t* segment = reinterpret_cast<const std::uint8_t*>(record);
  const float32x4_t weight = vld1q_f32(reinterpret_cast<const float*>(segment + 4));
  float32x4_t sum = vmulq_laneq_f32(moved(matrices + segment[0], p), weight, 0);
  if (!(vgetq_lane_f32(weight, 1) > 0)) return sum;
  sum = vaddq_f32(sum, vmulq_laneq_f32(moved(matrices + segment[1], p), weight, 1));
  if (!(vgetq_lane_f32(weight, 2) > 0)) return sum;
  sum = vaddq_f32(sum, vmulq_laneq_f32(moved(matrices + segment[2], p), weight, 2));
  if (!(vgetq_lane_f32(weight, 3) > 0)) return sum;
  return vaddq_f32(sum, vmulq_laneq_f32(moved(matrices + segment[3], p), weight, 3));
}

// Vertices that follow `segment` alone, its matrix in registers, while another is behind them. Returns how many.
inline int skin_followers(const float* vertices, const SkinRecord* records, int count, const SkinMatrix* matrices,
                          std::uint8_t segment, float* out) {
  const float* c = matrices[segment].column[0];
  const float32x4_t c0 = vld1q_f32(c), c1 = vld1q_f32(c + 4), c2 = vld1q_f32(c + 8), c3 = vld1q_f32(c + 12);
  int v = 0;
  for (; v + 1 < count; ++v, vertices += 3, out += 3) {
    const std::uint8_t* own = reinterpret_cast<const std::uint8_t*>(records + v);
    const float* weight = reinterpret_cast<const float*>(own + 4);
    if (own[0] != segment || weight[1] > 0) break;
    const float32x4_t p = vld1q_f32(vertices);
    const float32x4_t xy = vaddq_f32(vmulq_laneq_f32(c0, p, 0), vmulq_laneq_f32(c1, p, 1));
    vst1q_f32(out, vmulq_n_f32(vaddq_f32(vaddq_f32(xy, vmulq_laneq_f32(c2, p, 2)), c3), weight[0]));
  }
  return v;
}

}  // namespace

// Four values are read and written of each vertex but the last; the fourth is overwritten by the next vertex.
void skin_neon(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
               float* out) {
  while (vertex_count > 1) {
    const std::uint8_t* segment = reinterpret_cast<const std::uint8_t*>(records);
    int done = 1;
    if (reinterpret_cast<const float*>(segment + 4)[1] > 0)
      vst1q_f32(out, skinned(vld1q_f32(vertices), records, matrices));
    else
      done = skin_followers(vertices, records, vertex_count, matrices, segment[0], out);
    vertex_count -= done;
    vertices += 3 * done;
    out += 3 * done;
    records += done;
  }
  if (vertex_count == 0) return;
  const float32x4_t last = skinned(vcombine_f32(vld1_f32(vertices), vdup_n_f32(vertices[2])), records, matrices);
  vst1_f32(out, vget_low_f32(last));
  vst1q_lane_f32(out + 2, last, 2);
}

}  // namespace im2fit
#endif
