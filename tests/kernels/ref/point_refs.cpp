// SPDX-License-Identifier: Apache-2.0
// References of kernels over points and meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "kernels/normals/window.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

namespace joints {

void anchor_depths_ref(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                       std::int16_t* out, std::ptrdiff_t out_step) {
  for (int i = 0; i < count; ++i) {
    const Anchor& a = anchors[i];
    const float share = static_cast<float>(a.share_q8) / 256.0F;
    const auto between = [&](const float* of) { return of[a.joint] + (of[a.towards] - of[a.joint]) * share; };
    const float scale = between(joints.inverse_z);
    const float ray_x = (between(joints.x) + static_cast<float>(a.dx)) * scale;
    const float ray_y = (between(joints.y) + static_cast<float>(a.dy)) * scale;
    // Rounded at 8192, where a float's last place is 1/1024 px: to the nearest pixel but for that.
    const int u = static_cast<int>(std::floor(box.fx * ray_x + box.cx + 8192.5F)) - 8192 - box.u_first;
    const int v = static_cast<int>(std::floor(box.fy * ray_y + box.cy + 8192.5F)) - 8192 - box.v_first;
    out[i * out_step] = kAnchorFarMm;
    if (u < 0 || v < 0 || u >= box.width || v >= box.height) continue;
    const int depth = box.depth[static_cast<std::ptrdiff_t>(v) * box.width + u];
    if (depth != 0)
      out[i * out_step] =
          static_cast<std::int16_t>(std::clamp(depth - box.reference_mm, -kAnchorFarMm, kAnchorFarMm));
  }
}

}  // namespace joints

// Plane normals in double: all eigenvectors of the covariance by Jacobi's rotations.
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

void section_ref(const SectionScan& s, SectionPoint* points, int capacity, int* counts) {
  constexpr double kSlope = 1.0 / (1 << FormSlope::kFractionBits), kUnit = 1.0 / (1 << CoordinateMm::kFractionBits);
  constexpr double kSection = 1 << SectionMm::kFractionBits;
  for (int cut = 0; cut < s.cut_count; ++cut) counts[cut] = 0;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    for (int u = 0; u < s.depth_q4.width; ++u) {
      if (s.mask.at(u, v) == 0 || s.depth_q4.at(u, v) == 0) continue;
      const double z = s.depth_q4.at(u, v) / 16.0;
      const auto along = [&](const std::int32_t* columns, const std::int32_t* rows, std::int32_t centre) {
        return z * kSlope * (double{1} * columns[u] + rows[v]) - kUnit * centre;
      };
      for (int cut = 0; cut < s.cut_count; ++cut) {
        const SectionCut& c = s.cuts[cut];
        const double off = along(s.along_columns, s.along_rows, c.along), x = along(s.x_columns, s.x_rows, c.x),
                     y = along(s.y_columns, s.y_rows, c.y);
        const double rounded_x = std::floor(x * kSection + 0.5), rounded_y = std::floor(y * kSection + 0.5);
        if (std::fabs(rounded_x) > kSectionCoordinateMax || std::fabs(rounded_y) > kSectionCoordinateMax) continue;
        if (!(100 * off * off < off * off + x * x + y * y) || counts[cut] == capacity) continue;
        points[cut * (capacity + kSectionSlack) + counts[cut]++] = {static_cast<std::int16_t>(rounded_x),
                                                                    static_cast<std::int16_t>(rounded_y)};
      }
    }
  }
}

// v' = sum_s w_s (R_s v + t_s) (Magnenat-Thalmann et al. 1988).
void skin_ref(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
              float* out) {
  for (int v = 0; v < vertex_count; ++v) {
    const float* p = vertices + 3 * v;
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0;
      for (std::size_t i = 0; i < 4 && (i == 0 || records[v].weight[i] > 0); ++i) {
        const SkinMatrix& m = matrices[records[v].segment[i]];
        double moved = double{m.column[3][axis]};
        for (int j = 0; j < 3; ++j) moved += double{m.column[j][axis]} * double{p[j]};
        sum += moved * double{records[v].weight[i]};
      }
      out[3 * v + axis] = static_cast<float>(sum);
    }
  }
}

// The pinhole: x = (u - cx) z / fx, y = (v - cy) z / fy.
void unproject_ref(DepthView depth, int fraction_bits, const RayTable& rays, float* x, float* y, float* z) {
  const Intrinsics& k = rays.intrinsics();
  std::size_t i = 0;
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u, ++i) {
      const double mm = depth.at(u, v) / static_cast<double>(1 << fraction_bits);
      const bool none = mm == 0;
      x[i] =
          none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>((u - double{k.cx}) * mm / double{k.fx});
      y[i] =
          none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>((v - double{k.cy}) * mm / double{k.fy});
      z[i] = none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(mm);
    }
  }
}

}  // namespace im2fit
