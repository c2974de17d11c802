// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/skin/skin.h"

// ARMv7 runs portable: see the header.
#ifdef __aarch64__
namespace im2fit {
namespace {

inline float32x4_t moved(const SkinMatrix* m, float x, float y, float z, float weight) {
  const float* c = m->column[0];
  const float32x4_t xy = vaddq_f32(vmulq_n_f32(vld1q_f32(c), x), vmulq_n_f32(vld1q_f32(c + 4), y));
  const float32x4_t p = vaddq_f32(vaddq_f32(xy, vmulq_n_f32(vld1q_f32(c + 8), z)), vld1q_f32(c + 12));
  return vmulq_n_f32(p, weight);
}

}  // namespace

void skin_neon(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
               float* out) {
  for (int v = 0; v < vertex_count; ++v, vertices += 3, out += 3) {
    const std::uint8_t* segment = reinterpret_cast<const std::uint8_t*>(records + v);
    const float* weight = reinterpret_cast<const float*>(segment + 4);
    const float x = vertices[0], y = vertices[1], z = vertices[2];
    float32x4_t sum = moved(matrices + segment[0], x, y, z, weight[0]);
    for (int i = 1; i < 4 && weight[i] > 0; ++i)
      sum = vaddq_f32(sum, moved(matrices + segment[i], x, y, z, weight[i]));
    if (v + 1 < vertex_count) {
      vst1q_f32(out, sum);  // the fourth value is overwritten by the next vertex
    } else {
      vst1_f32(out, vget_low_f32(sum));
      vst1q_lane_f32(out + 2, sum, 2);
    }
  }
}

}  // namespace im2fit
#endif
