// SPDX-License-Identifier: Apache-2.0
// The ellipse fit about the points' mean and in their own scale, all three eigenvectors by the trigonometric cubic.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/paper/conic.h"
#include "perception/paper/ellipse.h"

namespace im2fit {

using conic_detail::Matrix3;
using conic_detail::Row3;

namespace {

// Roots of x^3 - c2 x^2 + c1 x - c0, all real (Viete).
Row3 real_roots(double c2, double c1, double c0) {
  const double shift = c2 / 3;
  const double p = c1 - c2 * c2 / 3;
  const double q = -2 * c2 * c2 * c2 / 27 + c2 * c1 / 3 - c0;
  if (!(p < 0)) return {shift, shift, shift};
  const double r = std::sqrt(-p / 3);
  const double angle = std::acos(std::clamp(3 * q / (2 * p * r), -1.0, 1.0)) / 3;
  const double third = 2 * std::numbers::pi / 3;
  return {shift + 2 * r * std::cos(angle), shift + 2 * r * std::cos(angle - third),
          shift + 2 * r * std::cos(angle - 2 * third)};
}

}  // namespace

Ellipse fit_ellipse_ref(std::span<const Point2> points) {
  if (points.size() < static_cast<std::size_t>(kEllipsePointsMin)) return {};
  const auto count = static_cast<double>(points.size());
  double mean_x = 0, mean_y = 0, scale = 0;
  for (const Point2& p : points) mean_x += p.x / count, mean_y += p.y / count;
  for (const Point2& p : points) scale += std::hypot(p.x - mean_x, p.y - mean_y) / count;
  if (!(scale > 0)) return {};

  conic_detail::Scatter s{};
  for (const Point2& point : points) {
    const double x = (point.x - mean_x) / scale, y = (point.y - mean_y) / scale;
    const Row3 quadratic = {x * x, x * y, y * y}, linear = {x, y, 1};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        s.s1[i][j] += quadratic[i] * quadratic[j];
        s.s2[i][j] += quadratic[i] * linear[j];
        s.s3[i][j] += linear[i] * linear[j];
      }
    }
  }
  Matrix3 t, m;
  if (!conic_detail::reduce(s, t, m)) return {};
  const double c2 = m[0][0] + m[1][1] + m[2][2];
  const double c1 = m[0][0] * m[1][1] - m[0][1] * m[1][0] + m[0][0] * m[2][2] - m[0][2] * m[2][0] +
                    m[1][1] * m[2][2] - m[1][2] * m[2][1];
  Ellipse best;
  for (const double root : real_roots(c2, c1, conic_detail::determinant(m))) {
    Matrix3 shifted = m;
    for (std::size_t i = 0; i < 3; ++i) shifted[i][i] -= root;
    for (std::size_t i = 0; i < 3; ++i) {
      const Row3 q = conic_detail::cross(shifted[i], shifted[(i + 1) % 3]);
      const Ellipse e = conic_detail::ellipse_of_conic(q, t);
      if (e.valid && !best.valid) best = {true, e.a * scale, e.b * scale};
    }
  }
  return best;
}

}  // namespace im2fit
