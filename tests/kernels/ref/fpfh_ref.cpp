// SPDX-License-Identifier: Apache-2.0
// FPFH as published (R. B. Rusu, N. Blodow, M. Beetz, "Fast Point Feature Histograms (FPFH) for 3D registration",
// ICRA 2009) with the choices PCL 1.13 makes where the paper leaves one: see kernels/fpfh/README.md. Brute force,
// double, libm.
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

struct Vec3d {
  double x, y, z;
};
Vec3d wide(Vec3f a) {
  return {a.x, a.y, a.z};
}
Vec3d operator-(Vec3d a, Vec3d b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vec3d operator*(Vec3d a, double s) {
  return {a.x * s, a.y * s, a.z * s};
}
double dot(Vec3d a, Vec3d b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Point {
  Vec3f position_m;
  Vec3f normal;
};
using Spfh = std::array<double, kFpfhSize>;

Vec3f metres(Vec3f mm) {
  return mm * 0.001F;
}

// In float, as the kd-tree inside PCL computes it: which points lie within the radius depends on this rounding.
float squared_distance(Vec3f a, Vec3f b) {
  const Vec3f d = a - b;
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

struct PairFeatures {
  double f1 = 0, f2 = 0, f3 = 0;  // zeros: the degenerate pair
};

// The swap decision in float, in PCL's order of operations: where the two normals are equal but for rounding (walls,
// quantised depth), f3's sign hangs on it, and rounded arc cosines are often equal where the cosines are not.
bool swaps(Vec3f n1, Vec3f n2, Vec3f d) {
  const auto dot4 = [](Vec3f a, Vec3f b) { return (a.x * b.x + a.z * b.z) + a.y * b.y; };
  const float length = std::sqrt(dot4(d, d));
  const float a1 = dot4(n1, d) / length, a2 = dot4(n2, d) / length;
  return std::acos(std::fabs(a1)) > std::acos(std::fabs(a2));  // false when either is NaN
}

// Eq. (2) of Rusu 2009; the pair's source is the point whose normal is nearer to the line between them.
PairFeatures pair_features(const Point& p, const Point& q) {
  const bool swap = swaps(p.normal, q.normal, q.position_m - p.position_m);
  const Vec3d source = wide(swap ? q.normal : p.normal), target = wide(swap ? p.normal : q.normal);
  const Vec3d from = wide(swap ? q.position_m : p.position_m), to = wide(swap ? p.position_m : q.position_m);
  const Vec3d line = to - from;
  const double length = std::sqrt(dot(line, line));
  if (length == 0) return {};
  const Vec3d v_long = cross(line, source);
  const double v_length = std::sqrt(dot(v_long, v_long));
  if (v_length == 0) return {};
  const Vec3d v = v_long * (1.0 / v_length);
  const Vec3d w = cross(source, v);
  return {std::atan2(dot(w, target), dot(source, target)), dot(v, target), dot(source, line) / length};
}

// A NaN converts to INT_MIN on the machines PCL was tried on, and is then clamped: bin 0.
int clamped_bin(double position) {
  if (!(position >= 0)) return 0;
  return position >= kFpfhBins ? kFpfhBins - 1 : static_cast<int>(position);
}

Spfh simplified_histogram(const std::vector<Point>& points, std::size_t source, float radius_squared) {
  Spfh counts{};
  int pair_count = 0;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (j == source) continue;
    if (!(squared_distance(points[source].position_m, points[j].position_m) < radius_squared)) continue;
    const PairFeatures f = pair_features(points[source], points[j]);
    counts[static_cast<std::size_t>(clamped_bin(kFpfhBins * (f.f1 + std::numbers::pi) / (2 * std::numbers::pi)))] +=
        1;
    counts[static_cast<std::size_t>(kFpfhBins + clamped_bin(kFpfhBins * (f.f2 + 1) / 2))] += 1;
    counts[static_cast<std::size_t>(2 * kFpfhBins + clamped_bin(kFpfhBins * (f.f3 + 1) / 2))] += 1;
    ++pair_count;
  }
  if (pair_count == 0) return counts;
  for (double& value : counts) value *= 100.0 / pair_count;
  return counts;
}

std::vector<Point> valid_points(const OrganisedCloud& cloud) {
  std::vector<Point> points;
  const std::size_t count =
      static_cast<std::size_t>(cloud.intrinsics.width) * static_cast<std::size_t>(cloud.intrinsics.height);
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::isfinite(cloud.x[i]) && std::isfinite(cloud.y[i]) && std::isfinite(cloud.z[i]) && cloud.z[i] > 0)) {
      continue;
    }
    points.push_back({metres({cloud.x[i], cloud.y[i], cloud.z[i]}), {cloud.nx[i], cloud.ny[i], cloud.nz[i]}});
  }
  return points;
}

}  // namespace

void fpfh_ref(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace&,
              std::span<float> out) {
  assert(out.size() == keypoints.size() * kFpfhSize);
  const std::vector<Point> points = valid_points(cloud);
  const double radius_m = double{radius_mm} / 1000.0;
  const float radius_squared = static_cast<float>(radius_m * radius_m);
  std::vector<std::optional<Spfh>> spfh(points.size());

  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    Spfh sum{};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const float d2 = squared_distance(metres(keypoints[k]), points[i].position_m);
      if (!(d2 < radius_squared) || d2 == 0) continue;
      if (!spfh[i]) spfh[i] = simplified_histogram(points, i, radius_squared);
      for (std::size_t b = 0; b < kFpfhSize; ++b) sum[b] += (*spfh[i])[b] / double{d2};
    }
    for (std::size_t group = 0; group < 3; ++group) {
      double total = 0;
      for (std::size_t b = 0; b < kFpfhBins; ++b) total += sum[group * kFpfhBins + b];
      for (std::size_t b = 0; b < kFpfhBins; ++b) {
        const double value = sum[group * kFpfhBins + b];
        out[k * kFpfhSize + group * kFpfhBins + b] = total > 0 ? static_cast<float>(value * (100.0 / total)) : 0.0F;
      }
    }
  }
}

}  // namespace im2fit
