// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/normals/normals.h"
#include "kernels/normals/row.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;
using V = __m256;
using M = __m256;

V splat(float value) {
  return _mm256_set1_ps(value);
}
V load(const float* p) {
  return _mm256_loadu_ps(p);
}
void store(float* p, V a) {
  _mm256_storeu_ps(p, a);
}
V root(V a) {
  return _mm256_sqrt_ps(a);
}
V negated(V a) {
  return _mm256_xor_ps(a, _mm256_set1_ps(-0.0F));
}
V size_of(V a) {
  return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a);
}
M above(V a, V b) {
  return _mm256_cmp_ps(a, b, _CMP_GT_OQ);
}
M not_above(V a, V b) {
  return _mm256_cmp_ps(a, b, _CMP_LE_OQ);
}
M both(M a, M b) {
  return _mm256_and_ps(a, b);
}
bool any(M a) {
  return _mm256_movemask_ps(a) != 0;
}
V where(M lanes, V a) {
  return _mm256_and_ps(lanes, a);
}
V either(M lanes, V a, V b) {
  return _mm256_blendv_ps(b, a, lanes);
}

#include "kernels/normals/normals_lanes.inc"

}  // namespace

void normals_avx2(const Intrinsics& intrinsics, const float* x, const float* y, const float* z, int radius_px,
                  float max_step_mm, float* nx, float* ny, float* nz) {
  normals_in_lanes({x, y, z, intrinsics.width, intrinsics.height, radius_px, max_step_mm}, nx, ny, nz);
}

}  // namespace im2fit
