// SPDX-License-Identifier: Apache-2.0
#include "body/section.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace im2fit::body {

SectionPlane level_plane(float y_mm) {
  return {{0, y_mm, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
}

SectionPlane plane_through(Vec3f origin, Vec3f normal) {
  const Vec3f n = normalized(normal);
  const Vec3f u = normalized(cross(n, n.x * n.x < 0.5F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0}));
  return {origin, u, cross(n, u), n};
}

void heights_along(std::span<const Vec3f> vertices, Vec3f normal, std::vector<float>& heights) {
  heights.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) heights[i] = dot(vertices[i], normal);
}

namespace {

// Where a triangle's edges cross: nothing, or both ends. Of a closed mesh, where two triangles share each edge and
// pass it in opposite directions, `downwards` alone are all.
void cross_level(const Triangle& corner, std::span<const Vec3f> vertices, std::span<const float> heights, float level,
                 bool downwards, std::vector<Vec3f>& out) {
  const auto height = [&](std::size_t i) { return heights[static_cast<std::size_t>(corner[i])] - level; };
  const std::array<float, 3> d = {height(0), height(1), height(2)};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = i == 2 ? 0 : i + 1;
    if ((d[i] > 0) == (d[j] > 0) || (downwards && !(d[i] > 0))) continue;
    const Vec3f& a = vertices[static_cast<std::size_t>(corner[i])];
    const Vec3f& b = vertices[static_cast<std::size_t>(corner[j])];
    out.push_back(a + (b - a) * (d[i] / (d[i] - d[j])));
  }
}

}  // namespace

void TriangleStack::clear() {
  triangles_.clear();
  along_.clear();
}

void TriangleStack::reserve(std::size_t triangle_count) {
  triangles_.reserve(triangle_count);
  along_.reserve(triangle_count);
}

void TriangleStack::add(const Triangle& triangle, std::span<const float> heights) {
  const auto height = [&](std::size_t i) { return heights[static_cast<std::size_t>(triangle[i])]; };
  triangles_.push_back(triangle);
  along_.add(std::min({height(0), height(1), height(2)}), std::max({height(0), height(1), height(2)}));
}

void TriangleStack::cut(std::span<const Vec3f> vertices, std::span<const float> heights, float level,
                        std::vector<Vec3f>& out) const {
  along_.at_level(level, [&](std::size_t t) { cross_level(triangles_[t], vertices, heights, level, true, out); });
}

void section_levels(std::span<const std::array<std::int32_t, 4>> quads, std::span<const std::uint8_t> skip,
                    std::span<const Vec3f> vertices, std::span<const float> heights, std::span<Level> levels) {
  std::vector<std::uint8_t> above;
  section_levels(quads, skip, vertices, heights, above, levels);
}

void section_levels(std::span<const std::array<std::int32_t, 4>> quads, std::span<const std::uint8_t> skip,
                    std::span<const Vec3f> vertices, std::span<const float> heights, std::vector<std::uint8_t>& above,
                    std::span<Level> levels) {
  static_assert(kLevelsMax <= 8);
  assert(levels.size() <= kLevelsMax);
  above.assign(heights.size(), 0);  // a bit a level
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const float level = levels[l].height;
    const auto bit = static_cast<std::uint8_t>(1U << l);
    for (std::size_t i = 0; i < heights.size(); ++i)
      above[i] = static_cast<std::uint8_t>(above[i] | (heights[i] - level > 0 ? bit : 0));
  }
  for (std::size_t q = 0; q < quads.size(); ++q) {
    const auto& quad = quads[q];
    const auto side = [&](std::size_t i) -> unsigned { return above[static_cast<std::size_t>(quad[i])]; };
    const unsigned a = side(0), b = side(1), c = side(2), d = side(3);
    const unsigned crossed = (a | b | c | d) & ~(a & b & c & d);
    if (crossed == 0) continue;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      if ((crossed >> l & 1U) == 0) continue;
      Level& level = levels[l];
      const auto cross = [&](std::size_t half, const Triangle& corner) {
        if (!level.heeds_skip || skip[2 * q + half] == 0)
          cross_level(corner, vertices, heights, level.height, !level.heeds_skip, level.points);
      };
      cross(0, {quad[0], quad[1], quad[2]});
      cross(1, {quad[0], quad[2], quad[3]});
    }
  }
}

std::vector<Vec3f> convex_hull(std::span<const Vec3f> points, const SectionPlane& plane) {
  HullWork work;
  std::vector<Vec3f> out;
  work.convex_hull(points, plane, out);
  return out;
}

void HullWork::reserve(std::size_t point_count) {
  flat_.reserve(point_count);
  hull_.reserve(2 * point_count);
}

// Twice the signed area, in double: float coordinates of a metre leave the sign of narrow triangles to chance.
double HullWork::turn(const Flat& o, const Flat& a, const Flat& b) {
  return (static_cast<double>(a.u) - o.u) * (static_cast<double>(b.v) - o.v) -
         (static_cast<double>(a.v) - o.v) * (static_cast<double>(b.u) - o.u);
}

// Andrew's monotone chain.
void HullWork::convex_hull(std::span<const Vec3f> points, const SectionPlane& plane, std::vector<Vec3f>& out) {
  flat_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3f p = points[i] - plane.origin;
    flat_.push_back({dot(p, plane.u), dot(p, plane.v), i});
  }
  std::sort(flat_.begin(), flat_.end(), [](const Flat& a, const Flat& b) {
    return a.u != b.u ? a.u < b.u : (a.v != b.v ? a.v < b.v : a.index < b.index);
  });
  flat_.erase(
      std::unique(flat_.begin(), flat_.end(), [](const Flat& a, const Flat& b) { return a.u == b.u && a.v == b.v; }),
      flat_.end());
  std::vector<Flat>& hull = hull_;
  hull.assign(2 * flat_.size(), {});
  std::size_t size = 0;
  if (flat_.size() >= 3) {
    for (std::size_t i = 0; i < flat_.size(); ++i) {
      while (size >= 2 && turn(hull[size - 2], hull[size - 1], flat_[i]) <= 0) --size;
      hull[size++] = flat_[i];
    }
    const std::size_t lower = size + 1;
    for (std::size_t i = flat_.size() - 1; i-- > 0;) {
      while (size >= lower && turn(hull[size - 2], hull[size - 1], flat_[i]) <= 0) --size;
      hull[size++] = flat_[i];
    }
    hull.resize(size - 1);  // the last point is the first again
  } else {
    hull = flat_;
  }
  out.clear();
  for (const Flat& f : hull) out.push_back(points[f.index]);
}

double perimeter_mm(std::span<const Vec3f> polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3f& a = polygon[i];
    const Vec3f& b = polygon[i + 1 == polygon.size() ? 0 : i + 1];
    const double x = static_cast<double>(b.x) - a.x;
    const double y = static_cast<double>(b.y) - a.y;
    const double z = static_cast<double>(b.z) - a.z;
    sum += std::sqrt(x * x + y * y + z * z);
  }
  return sum;
}

}  // namespace im2fit::body
