// SPDX-License-Identifier: Apache-2.0
// Direct least squares ellipse (Fitzgibbon, Pilu, Fisher, PAMI 1999) in the stable reduction of Halir and Flusser
// (1998).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace im2fit {

// Semi-axes a >= b in the unit of the points. valid is false where no ellipse fits: too few points, points on a line.
struct Ellipse {
  bool valid = false;
  double a = 0, b = 0;
  // Ramanujan's second formula (1914): relative error below 0.04 % for any ellipse, 1e-6 up to a = 3 b.
  double perimeter() const;
};

inline constexpr int kEllipsePointsMin = 12;

// Sums of x^i y^j, i + j <= 4: exact integers, so the order of points does not matter.
// Scaling and overflow: |x|, |y| <= 4096; kPointsMax of them at the corner reach 2^15 * 2^48 = 2^63.
class EllipseSums {
 public:
  static constexpr std::int32_t kCoordinateMax = 4095;
  static constexpr std::int64_t kPointsMax = 32767;

  void add(std::int32_t x, std::int32_t y);
  void add(const EllipseSums& other);
  std::int64_t count() const { return sum_[0]; }
  std::int64_t sum_x() const { return sum_[1]; }
  std::int64_t sum_y() const { return sum_[2]; }
  // Of x^i y^j in units of 2^10 coordinates, so that the fit works near one.
  double moment(int i, int j) const;

 private:
  static constexpr std::size_t index(int i, int j) {
    const int degree = i + j;
    return static_cast<std::size_t>(degree * (degree + 1) / 2 + j);
  }
  std::array<std::int64_t, 15> sum_{};
};

// Deterministic: + - * / sqrt in double. No allocation.
Ellipse fit_ellipse(const EllipseSums& sums);

struct Point2 {
  double x, y;
};
Ellipse fit_ellipse_ref(std::span<const Point2> points);

}  // namespace im2fit
