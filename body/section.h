// SPDX-License-Identifier: Apache-2.0
// Plane sections of a triangle mesh and the tape measure's way round them: the convex hull.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vec3.h"

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

// Where the triangles with skip[i] == 0 (all, if `skip` is empty) cross the plane: both ends of each crossing.
void section_points(std::span<const Triangle> triangles, std::span<const std::uint8_t> skip,
                    std::span<const Vec3f> vertices, const SectionPlane& plane, std::vector<Vec3f>& out);

// The same for many parallel planes: `heights` holds each vertex' coordinate along their normal.
void heights_along(std::span<const Vec3f> vertices, Vec3f normal, std::vector<float>& heights);
void section_points(std::span<const Triangle> triangles, std::span<const std::uint8_t> skip,
                    std::span<const Vec3f> vertices, std::span<const float> heights, float level,
                    std::vector<Vec3f>& out);

// Convex hull within the plane, counter-clockwise in (u, v), no point twice; fewer than three points: as they are.
std::vector<Vec3f> convex_hull(std::span<const Vec3f> points, const SectionPlane& plane);

// Length of the closed polygon, mm.
double perimeter_mm(std::span<const Vec3f> polygon);

}  // namespace im2fit::body
