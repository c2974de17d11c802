// SPDX-License-Identifier: Apache-2.0
// Direct least squares ellipse (Fitzgibbon, Pilu, Fisher, PAMI 1999) in the stable reduction of Halir and Flusser
// (1998).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/moments/moments.h"

namespace im2fit {

// Semi-axes a >= b in the unit of the points. valid is false where no ellipse fits: too few points, points on a line.
struct Ellipse {
  bool valid = false;
  double a = 0, b = 0;
  // Ramanujan's second formula (1914): relative error below 0.04 % for any ellipse, 1e-6 up to a = 3 b.
  double perimeter() const;
};

inline constexpr int kEllipsePointsMin = 12;

// Sums of x^i y^j, i + j <= 4: exact integers, so the order of points does not matter. Bounds: kernels/moments.
struct EllipseSums {
  std::array<std::int64_t, kMomentCount> sum{};

  std::int64_t count() const { return sum[0]; }
  // Of x^i y^j in units of 2^10 coordinates, so that the fit works near one.
  double moment(int i, int j) const;
};

// Deterministic: + - * / sqrt in double. No allocation.
Ellipse fit_ellipse(const EllipseSums& sums);

}  // namespace im2fit
