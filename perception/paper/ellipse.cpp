// SPDX-License-Identifier: Apache-2.0
#include "perception/paper/ellipse.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "perception/paper/conic.h"

namespace im2fit {

using conic_detail::Matrix3;
using conic_detail::Row3;

double Ellipse::perimeter() const {
  const double h = (a - b) * (a - b) / ((a + b) * (a + b));
  return std::numbers::pi * (a + b) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
}

void moments(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums) {
  std::int64_t s[kMomentCount] = {};
  for (int n = 0; n < count; ++n) {
    const std::int32_t x = points[n].x, y = points[n].y;
    if (x < first_x || x > last_x) continue;
    // Squares below 2^24: products of two of them need 64 bits.
    const std::int64_t xx = x * x, xy = x * y, yy = y * y;
    s[0] += 1;
    s[1] += x, s[2] += y;
    s[3] += xx, s[4] += xy, s[5] += yy;
    s[6] += xx * x, s[7] += xx * y, s[8] += yy * x, s[9] += yy * y;
    s[10] += xx * xx, s[11] += xx * xy, s[12] += xx * yy, s[13] += xy * yy, s[14] += yy * yy;
  }
  std::memcpy(sums, s, sizeof s);
}

double EllipseSums::moment(int i, int j) const {
  return static_cast<double>(sum[static_cast<std::size_t>(moment_index(i, j))]) /
         static_cast<double>(std::int64_t{1} << (10 * (i + j)));
}

namespace {

// The largest root of x^3 - c2 x^2 + c1 x - c0, all of whose roots are real and below `above`: Newton's method from
// there falls monotonically, so it ends where rounding stops the fall.
double largest_root(double c2, double c1, double c0, double above) {
  double x = above;
  for (int i = 0; i < 200; ++i) {
    const double value = ((x - c2) * x + c1) * x - c0;
    const double slope = (3 * x - 2 * c2) * x + c1;
    if (!(slope > 0)) break;
    const double next = x - value / slope;
    if (!(next < x)) break;
    x = next;
  }
  return x;
}

// The null vector of a matrix of rank two: the longest cross product of two rows.
Row3 null_vector(const Matrix3& m) {
  Row3 best{};
  double best_length = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Row3 c = conic_detail::cross(m[i], m[(i + 1) % 3]);
    const double length = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    if (length > best_length) {
      best = c;
      best_length = length;
    }
  }
  return best;
}

}  // namespace

Ellipse fit_ellipse(const EllipseSums& s) {
  if (s.count() < kEllipsePointsMin) return {};
  const auto m = [&](int i, int j) { return s.moment(i, j); };
  conic_detail::Scatter scatter = {
      {{{m(4, 0), m(3, 1), m(2, 2)}, {m(3, 1), m(2, 2), m(1, 3)}, {m(2, 2), m(1, 3), m(0, 4)}}},
      {{{m(3, 0), m(2, 1), m(2, 0)}, {m(2, 1), m(1, 2), m(1, 1)}, {m(1, 2), m(0, 3), m(0, 2)}}},
      {{{m(2, 0), m(1, 1), m(1, 0)}, {m(1, 1), m(0, 2), m(0, 1)}, {m(1, 0), m(0, 1), m(0, 0)}}}};
  Matrix3 t, reduced;
  if (!conic_detail::reduce(scatter, t, reduced)) return {};
  // C is indefinite with one positive eigenvalue and the scatter is positive semidefinite, so exactly one eigenvalue
  // of the reduced matrix is not negative, and it belongs to the ellipse.
  double largest = 0;
  for (const Row3& row : reduced) {
    for (const double value : row) largest = std::max(largest, std::fabs(value));
  }
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  for (Row3& row : reduced) {
    for (double& value : row) value /= largest;
  }
  const auto minor = [&](std::size_t i, std::size_t j) {
    return reduced[i][i] * reduced[j][j] - reduced[i][j] * reduced[j][i];
  };
  const double root = largest_root(reduced[0][0] + reduced[1][1] + reduced[2][2],
                                   minor(0, 1) + minor(0, 2) + minor(1, 2), conic_detail::determinant(reduced), 3.0);
  for (std::size_t i = 0; i < 3; ++i) reduced[i][i] -= root;
  Ellipse e = conic_detail::ellipse_of_conic(null_vector(reduced), t);
  e.a *= 1024;
  e.b *= 1024;
  return e;
}

}  // namespace im2fit
