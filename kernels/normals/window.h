// SPDX-License-Identifier: Apache-2.0
// The window's covariance, the part both tiers of normals share: in Real, in row order.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/camera.h"

namespace im2fit::normals_detail {

template <class Real>
struct Covariance {
  Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  bool enough = false;
};

// Covariance (times the count) of the usable points around (u, v). Differences are taken from the centre point first,
// so that float keeps its digits: a window spans centimetres, its distance metres.
template <class Real>
Covariance<Real> window_covariance(const Intrinsics& k, const float* x, const float* y, const float* z, int u, int v,
                                   int radius_px, float max_step_mm) {
  const auto at = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(column);
  };
  const std::size_t centre = at(u, v);
  const int u0 = std::max(0, u - radius_px), u1 = std::min(k.width - 1, u + radius_px);
  const int v0 = std::max(0, v - radius_px), v1 = std::min(k.height - 1, v + radius_px);
  Covariance<Real> c;
  Real sx = 0, sy = 0, sz = 0;
  int count = 0;
  for (int row = v0; row <= v1; ++row) {
    for (std::size_t i = at(u0, row); i <= at(u1, row); ++i) {
      if (!(std::fabs(z[i] - z[centre]) <= max_step_mm)) continue;  // NaN too
      const Real dx = Real{x[i]} - Real{x[centre]};
      const Real dy = Real{y[i]} - Real{y[centre]};
      const Real dz = Real{z[i]} - Real{z[centre]};
      sx += dx, sy += dy, sz += dz;
      c.xx += dx * dx, c.xy += dx * dy, c.xz += dx * dz;
      c.yy += dy * dy, c.yz += dy * dz, c.zz += dz * dz;
      ++count;
    }
  }
  const int side = 2 * radius_px + 1;
  c.enough = 2 * count >= side * side;
  if (!c.enough) return c;
  const Real inverse = Real{1} / static_cast<Real>(count);
  c.xx -= sx * sx * inverse, c.xy -= sx * sy * inverse, c.xz -= sx * sz * inverse;
  c.yy -= sy * sy * inverse, c.yz -= sy * sz * inverse, c.zz -= sz * sz * inverse;
  return c;
}

}  // namespace im2fit::normals_detail
