// SPDX-License-Identifier: Apache-2.0
// A body's point in one picture of a turning person: how far the surface seen lies before it, and how far the
// outline. Camera axes, mm.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "core/vec3.h"

namespace im2fit::body {

// Upright pictures of the intrinsics' size; 0 = no depth.
struct TurnPicture {
  ImageView<const std::uint16_t> depth;
  float depth_unit_mm = 1;
  MaskView mask;
  Intrinsics intrinsics;
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

}  // namespace im2fit::body
