// SPDX-License-Identifier: Apache-2.0
// A surface in blocks of consecutive triangles, neighbours mostly, with the box about each: the triangles at a plane
// or a height are found without checking all of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "body/section.h"

namespace im2fit::body {

class TriangleBlocks {
 public:
  // Keeps both lists as they are; to be placed again when vertices move. Memory is kept from call to call.
  void place(std::span<const Triangle> triangles, std::span<const Vec3f> vertices);
  std::span<const Triangle> triangles() const { return triangles_; }
  std::span<const Vec3f> vertices() const { return vertices_; }

  // Calls visit(first, triangles) in order with every block that may reach the plane: `first` is the number of its
  // first triangle in the list.
  template <class F>
  void at_plane(const SectionPlane& plane, F visit) const {
    near_plane(plane, 0, visit);
  }
  // The same for blocks that lie between two planes of one normal, or touch them.
  template <class F>
  void between(const SectionPlane& from, const SectionPlane& to, F visit) const {
    SectionPlane middle = from;
    middle.origin = (from.origin + to.origin) * 0.5F;
    const float half = 0.5F * dot(to.origin - from.origin, from.normal);
    near_plane(middle, half < 0 ? -half : half, visit);
  }
  // The same of a height.
  template <class F>
  void at_height(float y, F visit) const {
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const float away = boxes_[i].middle.y - y;
      if ((away < 0 ? -away : away) <= boxes_[i].half.y + kSlackMm) call(i, visit);
    }
  }

 private:
  static constexpr std::size_t kBlock = 16;  // triangles
  // More than rounding makes of a body's coordinates: no block that touches is passed by.
  static constexpr float kSlackMm = 0.05F;
  struct Box {
    Vec3f middle, half;
  };
  template <class F>
  void near_plane(const SectionPlane& plane, float reach_mm, F& visit) const {
    const Vec3f n = plane.normal;
    const auto size = [](float v) { return v < 0 ? -v : v; };
    const float nx = size(n.x), ny = size(n.y), nz = size(n.z), level = dot(plane.origin, n);
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const Box& box = boxes_[i];
      const float away = size(dot(box.middle, n) - level);
      if (away <= nx * box.half.x + ny * box.half.y + nz * box.half.z + reach_mm + kSlackMm) call(i, visit);
    }
  }
  template <class F>
  void call(std::size_t block, F& visit) const {
    const std::size_t first = block * kBlock;
    visit(first, triangles_.subspan(first, std::min(kBlock, triangles_.size() - first)));
  }

  std::span<const Triangle> triangles_;
  std::span<const Vec3f> vertices_;
  std::vector<Box> boxes_;
};

// The triangles between two parallel planes, for many cuts between them.
class TriangleSlab {
 public:
  // Keeps the vertices as they are. Memory is kept from call to call.
  void gather(const TriangleBlocks& mesh, const SectionPlane& from, const SectionPlane& to);
  std::span<const Vec3f> vertices() const { return vertices_; }
  // Calls visit(triangle) in the mesh's order with every one that a plane of the same normal crosses.
  template <class F>
  void at_level(float level, F visit) const {
    along_.at_level(level, [&](std::size_t i) { visit(triangles_[i]); });
  }

 private:
  std::span<const Vec3f> vertices_;
  std::vector<Triangle> triangles_;
  IntervalBlocks along_;  // the normal
};

}  // namespace im2fit::body
