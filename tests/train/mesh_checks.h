// SPDX-License-Identifier: Apache-2.0
// Brute force on triangle meshes: distances, inside or not, the hit of a ray.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/vec3.h"

namespace im2fit::lab {

using Corner = std::array<std::int32_t, 3>;

// Closest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
inline Vec3f closest_on(Vec3f p, Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3f bp = p - b;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const Vec3f cp = p - c;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const float scale = 1 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

inline Vec3f corner(std::span<const Vec3f> v, const Corner& t, std::size_t i) {
  return v[static_cast<std::size_t>(t[i])];
}

inline float distance_to(Vec3f p, std::span<const Vec3f> vertices, std::span<const Corner> triangles) {
  float best = 1e30F;
  for (const Corner& t : triangles) {
    const Vec3f d = p - closest_on(p, corner(vertices, t, 0), corner(vertices, t, 1), corner(vertices, t, 2));
    best = std::min(best, dot(d, d));
  }
  return std::sqrt(best);
}

// Where the ray origin + s direction meets a triangle, s > 0; -1: nowhere (Moeller and Trumbore 1997).
inline float meets(Vec3f origin, Vec3f direction, Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f e1 = b - a, e2 = c - a, p = cross(direction, e2);
  const float det = dot(e1, p);
  if (std::fabs(det) < 1e-9F) return -1;
  const Vec3f from_a = origin - a;
  const float u = dot(from_a, p) / det;
  if (u < 0 || u > 1) return -1;
  const Vec3f q = cross(from_a, e1);
  const float v = dot(direction, q) / det;
  if (v < 0 || u + v > 1) return -1;
  return dot(e2, q) / det;
}

// Nearest meeting, or -1.
inline float first_hit(Vec3f origin, Vec3f direction, std::span<const Vec3f> vertices,
                       std::span<const Corner> triangles) {
  float best = -1;
  for (const Corner& t : triangles) {
    const float s = meets(origin, direction, corner(vertices, t, 0), corner(vertices, t, 1), corner(vertices, t, 2));
    if (s > 0 && (best < 0 || s < best)) best = s;
  }
  return best;
}

// By the solid angle the mesh covers (van Oosterom and Strackee 1983), in turns: 1 inside a closed mesh, 0 outside;
// holes and overlaps only blur it.
inline float winding(Vec3f p, std::span<const Vec3f> vertices, std::span<const Corner> triangles) {
  double sum = 0;
  for (const Corner& t : triangles) {
    const Vec3f a = corner(vertices, t, 0) - p, b = corner(vertices, t, 1) - p, c = corner(vertices, t, 2) - p;
    const float la = norm(a), lb = norm(b), lc = norm(c);
    const float above = dot(a, cross(b, c));
    const float below = la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la;
    sum += 2 * std::atan2(static_cast<double>(above), static_cast<double>(below));
  }
  return static_cast<float>(sum / (4 * 3.14159265358979));
}

}  // namespace im2fit::lab
