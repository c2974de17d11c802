// SPDX-License-Identifier: Apache-2.0
// A body of the shape space in a pose, and how each of its points and joints moves with shape and pose: the Jacobian
// of linear blend skinning.
//
// A point of rest position x(c) with weights w_s on segments s of rotation R_s and offset t_s(c) stands at
//     p = sum_s w_s (R_s x + t_s),     t_s = posed head of s - R_s (rest head of s),
// both linear in the coefficients c for a given pose. With R = sum_s w_s R_s, along a direction n:
//     n . dp/dc_k   = (R' n) . dx/dc_k + sum_s w_s n . dt_s/dc_k
//     n . dp/dshift = n
//     n . dp/dturn_a = (q - w h_a) x n,  turn about the posed head h_a of segment a; w the weight and q the weighted
//                      position of the point on the segments that hang on a.
//
// + - * / and sqrt in written order; no allocation after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body/fit/normal_equations.h"
#include "body/shape_space.h"
#include "body/skeleton.h"

namespace im2fit::body {

// Segments that turn by themselves; head and hands follow.
inline constexpr std::array<Segment, 16> kTurning = {
    Segment::pelvis,          Segment::abdomen,         Segment::chest,           Segment::neck,
    Segment::left_shoulder,   Segment::left_upper_arm,  Segment::left_lower_arm,  Segment::right_shoulder,
    Segment::right_upper_arm, Segment::right_lower_arm, Segment::left_upper_leg,  Segment::left_lower_leg,
    Segment::left_foot,       Segment::right_upper_leg, Segment::right_lower_leg, Segment::right_foot};
// A step of a pose: the pelvis' shift in mm, then for each of kTurning a turn by |w| radians about w, axes of the
// mesh.
inline constexpr std::size_t kPoseValues = 3 + 3 * kTurning.size();
static_assert(1 + kTurning.size() <= kTripleMax);

// Applies `step` to `pose`. Turns of parents move all their descendants.
void move_pose(Pose& pose, std::span<const float, kPoseValues> step);

// Sets of segments, bit s for segment s.
using SegmentSet = std::uint32_t;
SegmentSet segments_of(const SkinRecord& skin);
// The triples of a pose step that move points attached to `segments`: the shift, then turns.
RowColumns columns_of(SegmentSet segments);

// Points that the same triples of a pose move: their equations are added up together.
struct PointGroup {
  RowColumns columns;
  std::vector<std::uint32_t> points;
};
std::vector<PointGroup> point_groups(const ShapeSpace& space);

// Points and bones of the body with some coefficients, rest pose.
class RestShape {
 public:
  explicit RestShape(const ShapeSpace& space);
  void set_bones(std::span<const float> coefficients);
  void set_points(std::span<const float> coefficients);
  // Moves the points last set: each `mm` of its own along its direction.
  void move_points(std::span<const float> mm, std::span<const Vec3f> directions);
  Vec3f middle(std::size_t point) const { return at(point * kPointValues); }
  Vec3f normal(std::size_t point) const {  // not of unit length
    return cross(at(point * kPointValues + 3), at(point * kPointValues + 6));
  }
  const Skeleton& skeleton() const { return skeleton_; }

 private:
  Vec3f at(std::size_t i) const { return {points_[i], points_[i + 1], points_[i + 2]}; }
  const FitLoops& loops_ = fit_loops();
  const ShapeSpace& space_;
  std::vector<float> points_, bones_;
  Skeleton skeleton_;
};

class PosedShape {
 public:
  // Both must outlive it.
  PosedShape(const ShapeSpace& space, const RestShape& rest);
  // Of the rest shape's present bones.
  void set(const Pose& pose);

  struct Point {
    std::size_t index = 0;
    std::array<Four, 3> turn{};  // columns of R above
    Vec3f position, normal;
    std::array<Four, 4> part{};  // w_s (R_s x + t_s)
  };
  void find(std::size_t index, Point& point) const;
  Vec3f head(Segment s) const { return posed_.head[static_cast<std::size_t>(s)]; }
  Vec3f tail(Segment s) const { return posed_.tail[static_cast<std::size_t>(s)]; }

  // Prefetches the data that point_row() reads of a point.
  void prefetch_row(std::size_t index) const {
    constexpr std::size_t kLine = 16;  // floats
    const float* basis = space_.point_basis.data() + index * kPointValues * space_.shape_count;
    for (std::size_t i = 0; i < 3 * space_.shape_count; i += kLine) __builtin_prefetch(basis + i);
  }

  // Slopes of n . p of the triples in `columns` (columns_of() the point's segments).
  void pose_row(const Point& point, Vec3f n, const RowColumns& columns, std::span<float> row) const;
  // The same, then those of the coefficients.
  void point_row(const Point& point, Vec3f n, const RowColumns& columns, std::span<float> row) const;
  // Of a segment's head or tail; `columns` as of that segment.
  void bone_row(Segment segment, bool tail, Vec3f n, const RowColumns& columns, std::span<float> row) const;

 private:
  void set_offset_moves();
  const float* moves_of(std::size_t segment) const { return offset_moves_.data() + segment * 3 * space_.shape_count; }

  const FitLoops& loops_ = fit_loops();
  const ShapeSpace& space_;
  const RestShape& rest_;
  Pose pose_;
  PosedSkeleton posed_;
  struct Move {
    std::array<Four, 3> column;  // of R_s
    Four offset;                 // t_s
  };
  std::array<Move, kSegmentCount> moves_{};
  std::vector<float> head_moves_;    // segment x 3 x shape: of the posed head
  std::vector<float> offset_moves_;  // segment x 3 x shape: dt_s/dc
};

}  // namespace im2fit::body
