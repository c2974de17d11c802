// SPDX-License-Identifier: Apache-2.0
#include "body/triangle_blocks.h"

namespace im2fit::body {

void TriangleBlocks::place(std::span<const Triangle> triangles, std::span<const Vec3f> vertices) {
  triangles_ = triangles;
  vertices_ = vertices;
  boxes_.clear();
  for (std::size_t begin = 0; begin < triangles.size(); begin += kBlock) {
    Vec3f low = vertices[static_cast<std::size_t>(triangles[begin][0])], high = low;
    for (const Triangle& t : triangles.subspan(begin, std::min(kBlock, triangles.size() - begin)))
      for (const std::int32_t corner : t) {
        const Vec3f p = vertices[static_cast<std::size_t>(corner)];
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
      }
    boxes_.push_back({(low + high) * 0.5F, (high - low) * 0.5F});
  }
}

void TriangleSlab::gather(const TriangleBlocks& mesh, const SectionPlane& from, const SectionPlane& to) {
  vertices_ = mesh.vertices();
  triangles_.clear();
  along_.clear();
  const Vec3f normal = from.normal;
  const float one = dot(from.origin, normal), other = dot(to.origin, normal);
  constexpr float kSlackMm = 0.05F;  // the planes between are rounded
  const float low = std::min(one, other) - kSlackMm, high = std::max(one, other) + kSlackMm;
  mesh.between(from, to, [&](std::size_t, std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles) {
      const auto height = [&](std::size_t i) { return dot(vertices_[static_cast<std::size_t>(t[i])], normal); };
      const float a = height(0), b = height(1), c = height(2);
      const float begin = std::min({a, b, c}), end = std::max({a, b, c});
      if (end < low || begin > high) continue;
      triangles_.push_back(t);
      along_.add(begin, end);
    }
  });
}

}  // namespace im2fit::body
