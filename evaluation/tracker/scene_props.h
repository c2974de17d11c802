// SPDX-License-Identifier: Apache-2.0
// What a virtual scene has no part for: an animal of capsules, and a wall with a mirror in it. Put into its depth by
// ray casting, with a Kinect's noise and without its shadows.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/floor_plane.h"
#include "core/rng.h"

namespace im2fit::lab {

// Axes of all below, mm: origin on the floor where the person stands, x to the camera's right, y up, z towards the
// camera.
struct PropCapsule {
  Vec3f from, to;
  float radius_mm = 0;
};

// Of a dog by default; scaled for others. It walks on a straight line.
struct Animal {
  std::vector<PropCapsule> parts;  // about the point on the floor below its middle
  Vec3f place;                     // in frame 0
  Vec3f step;                      // a frame
};
// `height_mm` at the shoulder; `heading_deg`: 0 to the camera's right, 90 away from it.
Animal make_animal(float height_mm, float heading_deg);

// A wall that is upright, with a rectangle in it through which the depth behind it is seen. A mirror image lies as
// far behind the wall as its object is before it; the scene must hold it.
struct MirrorWall {
  Vec3f normal = {0, 0, -1};                           // unit, without y, away from the person
  float distance_mm = 0;                               // from the person
  float half_width_mm = 0, bottom_mm = 0, top_mm = 0;  // of the mirror, about the person's foot on the wall
};

struct Props {
  std::optional<Animal> animal;
  std::optional<MirrorWall> mirror;
};

// Where they are, in the camera's axes. `distance_mm`: camera to person along the floor.
class PropAxes {
 public:
  PropAxes(const FloorPlane& floor, float distance_mm);
  Vec3f direction(Vec3f v) const { return right_ * v.x + up_ * v.y - forward_ * v.z; }
  Vec3f to_camera(Vec3f p) const { return base_ + direction(p); }
  Vec3f from_camera(Vec3f p) const;

 private:
  Vec3f up_, forward_, right_, base_;
};

// Draws frame `frame` of the props in front of `depth` (mm, 0: no data, stays). The same seed and frame give the same
// noise.
void draw_props(const Props& props, const PropAxes& axes, const Intrinsics& intrinsics, std::uint64_t seed,
                std::uint64_t frame, DepthImage depth);

}  // namespace im2fit::lab
