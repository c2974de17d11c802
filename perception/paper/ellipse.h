// SPDX-License-Identifier: Apache-2.0
// Direct least squares ellipse (Fitzgibbon, Pilu, Fisher, PAMI 1999) in the stable reduction of Halir and Flusser
// (1998).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/section/section.h"

namespace im2fit {

// Semi-axes a >= b in the unit of the points. valid is false where no ellipse fits: too few points, points on a line.
struct Ellipse {
  bool valid = false;
  double a = 0, b = 0;
  // Ramanujan's second formula (1914): relative error below 0.04 % for any ellipse, 1e-6 up to a = 3 b.
  double perimeter() const;
};

inline constexpr int kEllipsePointsMin = 12;

inline constexpr int kMomentCount = 15;
// The sum of x^i y^j: by degree, within one by falling power of x: 1, x, y, x^2, xy, y^2, x^3, ...
constexpr int moment_index(int i, int j) {
  return (i + j) * (i + j + 1) / 2 + j;
}
// kMomentPointsMax points at the corner reach 2^15 * 2^48 = 2^63.
inline constexpr int kMomentPointsMax = 32767;

// Sets kMomentCount sums of x^i y^j, i + j <= 4, over the points with first_x <= x <= last_x; |x|, |y| <=
// kSectionCoordinateMax, count <= kMomentPointsMax. Exact integers, so the order of points does not matter.
void moments(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums);

struct EllipseSums {
  std::array<std::int64_t, kMomentCount> sum{};

  std::int64_t count() const { return sum[0]; }
  // Of x^i y^j in units of 2^10 coordinates, so that the fit works near one.
  double moment(int i, int j) const;
};

// Deterministic: + - * / sqrt in double. No allocation.
Ellipse fit_ellipse(const EllipseSums& sums);

}  // namespace im2fit
