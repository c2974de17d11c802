// SPDX-License-Identifier: Apache-2.0
// Plane sections of a triangle mesh and the tape round them: the convex hull.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "body/interval_blocks.h"
#include "core/vec3.h"

namespace im2fit::body {

using Triangle = std::array<std::int32_t, 3>;

// A plane with two axes of its own, all unit length and perpendicular.
struct SectionPlane {
  Vec3f origin;
  Vec3f u;
  Vec3f v;
  Vec3f normal;
};
SectionPlane level_plane(float y_mm);
// Any u, v perpendicular to `normal` (not zero).
SectionPlane plane_through(Vec3f origin, Vec3f normal);

// Each vertex' coordinate along a normal.
void heights_along(std::span<const Vec3f> vertices, Vec3f normal, std::vector<float>& heights);

// A surface to be cut at many levels along one normal: triangles with where each begins and ends along it.
class TriangleStack {
 public:
  void clear();
  void reserve(std::size_t triangle_count);
  void add(const Triangle& triangle, std::span<const float> heights);
  // A point of each edge that crosses the level. Two triangles share an edge and pass it in opposite directions: the
  // one that goes down counts.
  void cut(std::span<const Vec3f> vertices, std::span<const float> heights, float level,
           std::vector<Vec3f>& out) const;

 private:
  std::vector<Triangle> triangles_;
  IntervalBlocks along_;
};

// The same of a mesh of quads at up to kLevelsMax levels in one pass. `skip` has two entries a quad, for its
// triangles 0 1 2 and 0 2 3; a level that heeds them takes both triangles' points of an edge, since one may be left
// out.
inline constexpr std::size_t kLevelsMax = 8;
struct Level {
  float height = 0;
  bool heeds_skip = false;
  std::vector<Vec3f> points;  // added to
};
void section_levels(std::span<const std::array<std::int32_t, 4>> quads, std::span<const std::uint8_t> skip,
                    std::span<const Vec3f> vertices, std::span<const float> heights, std::span<Level> levels);
// The same with memory for the work that is used from call to call.
void section_levels(std::span<const std::array<std::int32_t, 4>> quads, std::span<const std::uint8_t> skip,
                    std::span<const Vec3f> vertices, std::span<const float> heights, std::vector<std::uint8_t>& above,
                    std::span<Level> levels);

// Convex hull within the plane, counter-clockwise in (u, v), no point twice; fewer than three points: as they are.
std::vector<Vec3f> convex_hull(std::span<const Vec3f> points, const SectionPlane& plane);
// The same without allocation up to the largest number of points already processed or reserved.
class HullWork {
 public:
  void reserve(std::size_t point_count);
  void convex_hull(std::span<const Vec3f> points, const SectionPlane& plane, std::vector<Vec3f>& out);

 private:
  struct Flat {
    float u, v;
    std::size_t index;
  };
  static double turn(const Flat& o, const Flat& a, const Flat& b);
  std::vector<Flat> flat_, hull_;
};

// Length of the closed polygon, mm.
double perimeter_mm(std::span<const Vec3f> polygon);

}  // namespace im2fit::body
