// SPDX-License-Identifier: Apache-2.0
// Plane normals in float with + - * / sqrt only: the smallest eigenvector without an eigenvalue solver.
#include <cmath>
#include <limits>

#include "core/vec3.h"
#include "kernels/normals/normals.h"
#include "kernels/normals/row.h"
#include "kernels/normals/window.h"

namespace im2fit {
namespace {

using normals_detail::Covariance;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Symmetric {
  float xx, xy, xz, yy, yz, zz;
  float trace() const { return xx + yy + zz; }
  Symmetric scaled(float s) const { return {xx * s, xy * s, xz * s, yy * s, yz * s, zz * s}; }
  Symmetric squared() const {
    return {xx * xx + xy * xy + xz * xz, xx * xy + xy * yy + xz * yz, xx * xz + xy * yz + xz * zz,
            xy * xy + yy * yy + yz * yz, xy * xz + yy * yz + yz * zz, xz * xz + yz * yz + zz * zz};
  }
};

Symmetric adjugate(const Symmetric& c) {
  return {c.yy * c.zz - c.yz * c.yz, c.xz * c.yz - c.xy * c.zz, c.xy * c.yz - c.xz * c.yy,
          c.xx * c.zz - c.xz * c.xz, c.xy * c.xz - c.xx * c.yz, c.xx * c.yy - c.xy * c.xy};
}

// The adjugate has the covariance's eigenvectors with eigenvalues l2 l3 >= l1 l3 >= l1 l2: its largest belongs to
// the smallest l1. Five squarings raise the ratio l1/l2 of what disturbs to the 32nd power; what remains is the
// projector n n^T.
bool smallest_eigenvector(const Covariance<float>& covariance, Vec3f& n) {
  Symmetric c = {covariance.xx, covariance.xy, covariance.xz, covariance.yy, covariance.yz, covariance.zz};
  const float spread = c.trace();
  if (!(spread > 0.0F)) return false;
  c = c.scaled(1.0F / spread);
  Symmetric m = adjugate(c);
  const float area = m.trace();  // l2 l3 + l1 (l2 + l3), of eigenvalues that add to one
  if (!(area > kNormalsLineShare)) return false;
  m = m.scaled(1.0F / area);
  for (int i = 0; i < 5; ++i) {
    m = m.squared();
    m = m.scaled(1.0F / m.trace());
  }
  if (m.xx >= m.yy && m.xx >= m.zz) {
    n = {m.xx, m.xy, m.xz};
  } else if (m.yy >= m.zz) {
    n = {m.xy, m.yy, m.yz};
  } else {
    n = {m.xz, m.yz, m.zz};
  }
  n = normalized(n);
  return true;
}

}  // namespace

void normals_detail::normals_of_row(const float* x, const float* y, const float* z, int width, int height, int v,
                                    int u_begin, int u_end, int radius_px, float max_step_mm, float* nx, float* ny,
                                    float* nz) {
  Intrinsics size;
  size.width = width;
  size.height = height;
  for (int u = u_begin; u < u_end; ++u) {
    const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
    nx[i] = ny[i] = nz[i] = kNan;
    if (!(z[i] > 0.0F)) continue;
    const auto covariance = window_covariance<float>(size, x, y, z, u, v, radius_px, max_step_mm);
    Vec3f n;
    if (!covariance.enough || !smallest_eigenvector(covariance, n)) continue;
    if (n.x * x[i] + n.y * y[i] + n.z * z[i] > 0.0F) n = -n;
    nx[i] = n.x;
    ny[i] = n.y;
    nz[i] = n.z;
  }
}

void normals_portable(const Intrinsics& intrinsics, const float* x, const float* y, const float* z, int radius_px,
                      float max_step_mm, float* nx, float* ny, float* nz) {
  for (int v = 0; v < intrinsics.height; ++v) {
    normals_detail::normals_of_row(x, y, z, intrinsics.width, intrinsics.height, v, 0, intrinsics.width, radius_px,
                                   max_step_mm, nx, ny, nz);
  }
}

void normals(const Intrinsics& intrinsics, const float* x, const float* y, const float* z, int radius_px,
             float max_step_mm, float* nx, float* ny, float* nz) {
  IM2FIT_CHOSEN_ONCE best = fastest(kNormalsKernels);
  best(intrinsics, x, y, z, radius_px, max_step_mm, nx, ny, nz);
}

}  // namespace im2fit
