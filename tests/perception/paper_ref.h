// SPDX-License-Identifier: Apache-2.0
// The references of perception/paper: its measurements in double, as Eqs. (2)-(4) read, and the ellipse fit about the
// points' mean and in their own scale, all three eigenvectors by the trigonometric cubic.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "perception/paper/conic.h"
#include "perception/paper/ellipse.h"
#include "perception/paper/plan.h"

namespace im2fit::paper_ref {

struct Point2 {
  double x, y;
};

using conic_detail::Matrix3;
using conic_detail::Row3;

// Roots of x^3 - c2 x^2 + c1 x - c0, all real (Viete).
inline Row3 real_roots(double c2, double c1, double c0) {
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

inline Ellipse fit_ellipse_ref(std::span<const Point2> points) {
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

struct Vec3d {
  double x = 0, y = 0, z = 0;
};
inline Vec3d wide(Vec3f a) {
  return {a.x, a.y, a.z};
}
inline Vec3d operator-(Vec3d a, Vec3d b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline double dot(Vec3d a, Vec3d b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec3d a) {
  return std::sqrt(dot(a, a));
}
inline Vec3d unit(Vec3d a) {
  return {a.x / norm(a), a.y / norm(a), a.z / norm(a)};
}

struct SeenPoint {
  Vec3d position;
  int row;
  bool contour;
};

inline std::vector<SeenPoint> seen_points(ImageView<const std::uint16_t> depth_q4, MaskView mask,
                                          const Intrinsics& k) {
  std::vector<SeenPoint> points;
  const auto inside = [&](int u, int v) {
    return u >= 0 && v >= 0 && u < mask.width && v < mask.height && mask.at(u, v) != 0;
  };
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (!inside(u, v) || depth_q4.at(u, v) == 0) continue;
      const double z = depth_q4.at(u, v) / 16.0;
      const bool contour = !(inside(u - 1, v) && inside(u + 1, v) && inside(u, v - 1) && inside(u, v + 1));
      points.push_back(
          {{(u - double{k.cx}) * z / double{k.fx}, (v - double{k.cy}) * z / double{k.fy}, z}, v, contour});
    }
  }
  return points;
}

inline double stature(const std::vector<SeenPoint>& points, Vec3d torso, Vec3d v) {
  struct End {
    int row = -1;
    double side = 0;
    Vec3d position;
  } top, bottom;
  for (const SeenPoint& p : points) {
    const Vec3d d = p.position - torso;
    const double side = std::fabs(dot(v, d));
    if (!p.contour || !(side / norm(d) < 0.1)) continue;
    if (top.row < 0 || (p.row == top.row && side < top.side)) top = {p.row, side, p.position};
    if (p.row > bottom.row || side < bottom.side) bottom = {p.row, side, p.position};
  }
  return top.row < bottom.row ? norm(bottom.position - top.position) : std::numeric_limits<double>::quiet_NaN();
}

inline float girth(const std::vector<SeenPoint>& points, Vec3f centre, float fx, Vec3d u, Vec3d across, Vec3d w) {
  struct Bin {
    std::vector<Point2> points;
    double depth_sum = 0;
  };
  std::vector<Bin> bins(PaperWorkspace::kBinCount);
  for (const SeenPoint& p : points) {
    const Vec3d d = p.position - wide(centre);
    if (!(std::fabs(dot(u, d)) / norm(d) < 0.1)) continue;
    const double x = dot(across, d), y = dot(w, d);
    constexpr double kHalf = paper_detail::kSectionHalfMm;
    if (std::fabs(x) >= kHalf || std::fabs(y) >= kHalf) continue;
    Bin& bin = bins[static_cast<std::size_t>((x + kHalf) / paper_detail::kBinMm)];
    bin.points.push_back({x, y});
    bin.depth_sum += y;
  }
  const auto bin = [&](int b) -> const Bin& { return bins[static_cast<std::size_t>(b)]; };
  const paper_detail::BinRange range = paper_detail::connected_bins(
      paper_detail::hole_bins(centre.z, fx), [&](int b) { return bin(b).points.size(); },
      [&](int b) { return bin(b).depth_sum / static_cast<double>(bin(b).points.size()); });
  std::vector<Point2> section;
  for (int b = range.first; b <= range.last; ++b) {
    section.insert(section.end(), bin(b).points.begin(), bin(b).points.end());
  }
  const Ellipse ellipse = fit_ellipse_ref(section);
  return ellipse.valid ? static_cast<float>(ellipse.perimeter()) : std::numeric_limits<float>::quiet_NaN();
}

inline PaperMeasurements measure_paper_ref(ImageView<const std::uint16_t> depth_q4, MaskView mask,
                                           const Intrinsics& intrinsics, const JointSet& joints, PaperWorkspace&) {
  PaperMeasurements m = paper_detail::unmeasured();
  if (!(im2fit::norm(body_frame(joints).w) > 0)) return m;
  const auto at = [&](Joint j) { return wide(joints[j]); };
  const Vec3d u = unit(at(Joint::TO) - at(Joint::NE)), v = unit(at(Joint::RS) - at(Joint::LS)), w = unit(cross(u, v));
  const std::vector<SeenPoint> points = seen_points(depth_q4, mask, intrinsics);

  m.stature_mm = static_cast<float>(stature(points, at(Joint::TO), v));
  using enum Joint;
  const auto distance = [&](Joint a, Joint b) { return norm(at(a) - at(b)); };
  m.sleeve_mm = static_cast<float>((distance(LA, LE) + distance(LE, LS) + distance(LS, NE) + distance(RA, RE) +
                                    distance(RE, RS) + distance(RS, NE)) /
                                   2);
  m.leg_mm = static_cast<float>((distance(LH, LK) + distance(LK, LF) + distance(RH, RK) + distance(RK, RF)) / 2);
  m.shoulder_mm = static_cast<float>(distance(LS, RS));
  const auto centres = paper_detail::section_centres(joints);
  std::array<float, kPaperSectionCount> girths;
  for (std::size_t s = 0; s < kPaperSectionCount; ++s) {
    girths[s] = girth(points, centres[s], intrinsics.fx, u, cross(w, u), w);
  }
  paper_detail::set_girths(girths, m);
  m.chest_ratio = paper_detail::surface_ratio(depth_q4, mask, intrinsics, joints);
  m.valid = !std::isnan(m.stature_mm);
  return m;
}

}  // namespace im2fit::paper_ref
