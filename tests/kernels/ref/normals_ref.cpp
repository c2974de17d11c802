// SPDX-License-Identifier: Apache-2.0
// Plane normals in double: all eigenvectors of the covariance by Jacobi's rotations.
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/normals/window.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

// On return the diagonal of `a` holds the eigenvalues and the columns of the result the eigenvectors.
Matrix jacobi(Matrix& a) {
  Matrix q = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  constexpr std::pair<std::size_t, std::size_t> kPlanes[] = {{0, 1}, {0, 2}, {1, 2}};
  for (int sweep = 0; sweep < 12; ++sweep) {
    for (const auto& [r, s] : kPlanes) {
      if (a[r][s] == 0) continue;
      const double theta = 0.5 * std::atan2(2 * a[r][s], a[s][s] - a[r][r]);
      const double c = std::cos(theta), d = std::sin(theta);
      for (std::size_t i = 0; i < 3; ++i) {
        const double ar = a[i][r], as = a[i][s];
        a[i][r] = c * ar - d * as, a[i][s] = d * ar + c * as;
      }
      for (std::size_t i = 0; i < 3; ++i) {
        const double ar = a[r][i], as = a[s][i];
        a[r][i] = c * ar - d * as, a[s][i] = d * ar + c * as;
        const double qr = q[i][r], qs = q[i][s];
        q[i][r] = c * qr - d * qs, q[i][s] = d * qr + c * qs;
      }
    }
  }
  return q;
}

}  // namespace

void normals_ref(const Intrinsics& intrinsics, const float* x, const float* y, const float* z, int radius_px,
                 float max_step_mm, float* nx, float* ny, float* nz) {
  std::size_t i = 0;
  for (int v = 0; v < intrinsics.height; ++v) {
    for (int u = 0; u < intrinsics.width; ++u, ++i) {
      nx[i] = ny[i] = nz[i] = std::numeric_limits<float>::quiet_NaN();
      if (!(z[i] > 0)) continue;
      const auto c = normals_detail::window_covariance<double>(intrinsics, x, y, z, u, v, radius_px, max_step_mm);
      if (!c.enough) continue;
      Matrix a = {{{c.xx, c.xy, c.xz}, {c.xy, c.yy, c.yz}, {c.xz, c.yz, c.zz}}};
      const Matrix q = jacobi(a);
      std::size_t least = 0;
      for (std::size_t e = 1; e < 3; ++e) {
        if (a[e][e] < a[least][least]) least = e;
      }
      const double l1 = a[least][least], l2 = a[(least + 1) % 3][(least + 1) % 3],
                   l3 = a[(least + 2) % 3][(least + 2) % 3], sum = l1 + l2 + l3;
      if (!(l2 * l3 + l1 * (l2 + l3) > double{kNormalsLineShare} * sum * sum)) continue;
      const double sign = q[0][least] * x[i] + q[1][least] * y[i] + q[2][least] * z[i] > 0 ? -1.0 : 1.0;
      nx[i] = static_cast<float>(sign * q[0][least]);
      ny[i] = static_cast<float>(sign * q[1][least]);
      nz[i] = static_cast<float>(sign * q[2][least]);
    }
  }
}

}  // namespace im2fit
