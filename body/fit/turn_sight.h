// SPDX-License-Identifier: Apache-2.0
// What one picture of a turning person shows of a body: how far the surface seen lies before a point, how far the
// outline, and which points other parts of the body hide. Camera axes, mm.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "body/fit/posed_shape.h"
#include "body/fit/skin_bumps.h"
#include "body/person_axes.h"
#include "body/shape_space.h"
#include "body/skeleton.h"
#include "core/camera.h"
#include "core/vec3.h"

namespace im2fit::body {

// Upright pictures of the intrinsics' size; 0 = no depth.
struct TurnPicture {
  ImageView<const std::uint16_t> depth;
  float depth_unit_mm = 1;
  MaskView mask;
  Intrinsics intrinsics;
  std::optional<PersonAxes> axes = {};  // of a camera that is carried round; none: it stands where it stood
};
// Sizes that agree, and finite intrinsics within those of a camera.
bool usable(const TurnPicture& picture);

class TurnSight {
 public:
  explicit TurnSight(const TurnPicture& picture);

  // Along the normal n of p: the mean over the pixels about p's own, so that one pixel's noise counts less. They are
  // few enough that the curvature of an arm moves it by 0.1 mm. False near an edge of the surface, where depth is
  // mixed, and where it lies `gate_mm` or more before or behind p.
  bool surface_over(Vec3f p, Vec3f n, float gate_mm, float& off_mm) const;

  // Where the person ends along the image of p's normal, `direction` (x and y, unit): positive when p is to move
  // that way. The surface inside lies within 120 mm of p's depth, and no part of the person follows outside. The
  // border of the picture does not count as an end.
  bool outline_beside(Vec3f p, Vec3f n, float reach_mm, float& off_mm, Vec3f& direction) const;

 private:
  float depth_mm(int u, int v) const { return static_cast<float>(picture_.depth.at(u, v)) * picture_.depth_unit_mm; }
  bool project(Vec3f p, float& u, float& v) const;
  bool clear_of_edges(int u, int v, float depth) const;

  const TurnPicture& picture_;
  const Intrinsics& k_;
  int margin_px_;
};

// The points of a body in a pose, as a camera sees them. No allocation after construction.
class TurnPoints {
 public:
  // All must outlive it.
  TurnPoints(const ShapeSpace& space, const RestShape& rest, const SkinGraph& graph);
  // Of the rest shape's present points and bones; what follows is of this pose and camera. `axes`: of the pose.
  void see(const Pose& pose, const Intrinsics& intrinsics, const PersonAxes& axes);

  const PosedShape& posed() const { return posed_; }
  const PosedShape::Point& at(std::size_t i) const { return points_[i]; }
  Vec3f in_camera(std::size_t i) const { return in_camera_[i]; }
  // Cosine between the point's normal and the direction to the camera.
  float facing(std::size_t i) const { return facing_[i]; }
  bool hidden(std::size_t i) const;
  // Of a point near the outline.
  float beyond_mm(std::size_t i) const;

 private:
  void fill_cells(Vec3f c, int cells, std::uint32_t point);
  Vec3f rest_middle(std::size_t i) const;

  const ShapeSpace& space_;
  const SkinGraph& graph_;
  PosedShape posed_;
  std::vector<PosedShape::Point> points_;
  std::vector<Vec3f> in_camera_;
  std::vector<float> facing_;
  struct Near {
    float depth = 0;  // of the nearest point that faces the camera; 0: none
    std::uint32_t point = 0;
  };
  std::vector<Near> nearest_;  // of each cell
  Vec3f camera_;
  Intrinsics seen_k_;
  int cells_x_ = 0, cells_y_ = 0;
  float cell_px_ = 1;
};

}  // namespace im2fit::body
