// SPDX-License-Identifier: Apache-2.0
// Plane sections of a triangle mesh as closed lines, and the two tapes on them: round one, and along a part of one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "body/section.h"
#include "body/triangle_blocks.h"

namespace im2fit::body {

// Whether a closed line in the plane goes round the point, as seen along the plane's normal.
bool goes_round(std::span<const Vec3f> loop, const SectionPlane& plane, Vec3f point);

// Memory grows with the largest section seen and is kept from call to call.
class Contours {
 public:
  // The lines in which the plane meets the mesh: each closed where the mesh is. Triangles consistently oriented.
  void cut(const TriangleBlocks& mesh, const SectionPlane& plane);
  // The same for the slab of triangles about the plane.
  void cut(const TriangleSlab& slab, const SectionPlane& plane);
  std::size_t count() const { return first_.empty() ? 0 : first_.size() - 1; }
  std::span<const Vec3f> loop(std::size_t i) const;
  std::span<const Vec3f> points() const { return points_; }  // of all lines

  // Of several lines (trunk and arms, two legs) the one about `inside`: the shortest that goes round it, else the one
  // with the nearest middle. Empty if no line has three points or more.
  std::span<const Vec3f> about(Vec3f inside) const;
  // The line that passes nearest to both ends.
  std::span<const Vec3f> through(Vec3f from, Vec3f to) const;

 private:
  struct Step {
    std::uint64_t from_edge, to_edge;
    Vec3f point;  // on to_edge
  };
  void join();
  void add_step(const Triangle& triangle, std::span<const Vec3f> vertices, float level);

  SectionPlane plane_{};
  std::vector<Step> steps_;
  std::vector<std::size_t> next_;
  std::vector<std::uint8_t> state_;
  std::vector<Vec3f> points_;
  std::vector<std::size_t> first_;
};

// The part of a closed line from near `from` to near `to`, on the way that passes near `via`, pulled taut on its
// outer side: a tape bridges hollows. Into `out`; ends are on the line.
void taut_path(std::span<const Vec3f> loop, const SectionPlane& plane, Vec3f from, Vec3f via, Vec3f to,
               std::vector<Vec3f>& out);
// Length of an open line, mm.
double path_mm(std::span<const Vec3f> path);

}  // namespace im2fit::body
