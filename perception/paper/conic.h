// SPDX-License-Identifier: Apache-2.0
// The 3x3 algebra both ellipse fits share.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "perception/paper/ellipse.h"

namespace im2fit::conic_detail {

using Row3 = std::array<double, 3>;
using Matrix3 = std::array<Row3, 3>;

// Halir and Flusser's S1 = D1'D1, S2 = D1'D2, S3 = D2'D2, D1 = [x^2 xy y^2], D2 = [x y 1].
struct Scatter {
  Matrix3 s1, s2, s3;
};

inline Row3 cross(const Row3& a, const Row3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Row3& a, const Row3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double determinant(const Matrix3& m) {
  return dot(m[0], cross(m[1], m[2]));
}

// t = -S3^-1 S2', reduced = C1^-1 (S1 + S2 t). False where the points lie on a line (S3 singular).
inline bool reduce(const Scatter& s, Matrix3& t, Matrix3& reduced) {
  const double det = determinant(s.s3);
  const double trace = s.s3[0][0] + s.s3[1][1] + s.s3[2][2];
  if (!(det > 1e-12 * trace * trace * trace)) return false;
  const Matrix3 adjugate = {cross(s.s3[1], s.s3[2]), cross(s.s3[2], s.s3[0]), cross(s.s3[0], s.s3[1])};  // symmetric
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) t[i][j] = -dot(adjugate[i], s.s2[j]) / det;
  }
  Matrix3 m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      m[i][j] = s.s1[i][j] + (s.s2[i][0] * t[0][j] + s.s2[i][1] * t[1][j] + s.s2[i][2] * t[2][j]);
    }
  }
  for (std::size_t j = 0; j < 3; ++j) {
    reduced[0][j] = m[2][j] / 2;
    reduced[1][j] = -m[1][j];
    reduced[2][j] = m[0][j] / 2;
  }
  return true;
}

// The conic q[0] x^2 + q[1] xy + q[2] y^2 + ..., whose lower half is t q.
inline Ellipse ellipse_of_conic(const Row3& q, const Matrix3& t) {
  const double discriminant = 4 * q[0] * q[2] - q[1] * q[1];
  if (!(discriminant > 0)) return {};
  const double d = dot(t[0], q), e = dot(t[1], q), f = dot(t[2], q);
  // The conic's value at its centre, times the discriminant.
  const double centre = q[0] * e * e + q[2] * d * d - q[1] * d * e - discriminant * f;
  const double sum = q[0] + q[2];
  const double difference = std::sqrt((q[0] - q[2]) * (q[0] - q[2]) + q[1] * q[1]);
  const double a2 = 2 * centre * (sum + (sum > 0 ? difference : -difference));
  const double b2 = 2 * centre * (sum - (sum > 0 ? difference : -difference));
  if (!(a2 > 0) || !(b2 > 0)) return {};
  const double a = std::sqrt(a2) / discriminant, b = std::sqrt(b2) / discriminant;
  if (!std::isfinite(a) || !std::isfinite(b)) return {};
  return {true, a > b ? a : b, a > b ? b : a};
}

}  // namespace im2fit::conic_detail
