// SPDX-License-Identifier: Apache-2.0
// AArch64 only: see normals.h.
#ifdef __aarch64__
#include <arm_neon.h>

#include "kernels/normals/normals.h"
#include "kernels/normals/row.h"

namespace im2fit {
namespace {

constexpr int kLanes = 4;
using V = float32x4_t;
using M = uint32x4_t;

V splat(float value) {
  return vdupq_n_f32(value);
}
V load(const float* p) {
  return vld1q_f32(p);
}
void store(float* p, V a) {
  vst1q_f32(p, a);
}
V root(V a) {
  return vsqrtq_f32(a);
}
V negated(V a) {
  return vnegq_f32(a);
}
V size_of(V a) {
  return vabsq_f32(a);
}
M above(V a, V b) {
  return vcgtq_f32(a, b);
}
M not_above(V a, V b) {
  return vcleq_f32(a, b);
}
M both(M a, M b) {
  return vandq_u32(a, b);
}
bool any(M a) {
  return vmaxvq_u32(a) != 0;
}
V where(M lanes, V a) {
  return vreinterpretq_f32_u32(vandq_u32(lanes, vreinterpretq_u32_f32(a)));
}
V either(M lanes, V a, V b) {
  return vbslq_f32(lanes, a, b);
}

#include "kernels/normals/normals_lanes.inc"

}  // namespace

void normals_neon(const Intrinsics& intrinsics, const float* x, const float* y, const float* z, int radius_px,
                  float max_step_mm, float* nx, float* ny, float* nz) {
  normals_in_lanes({x, y, z, intrinsics.width, intrinsics.height, radius_px, max_step_mm}, nx, ny, nz);
}

}  // namespace im2fit
#endif
