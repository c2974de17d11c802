// SPDX-License-Identifier: Apache-2.0
// Coordinates on the person: height above the floor, sideways, and towards the camera. Levelled by the floor, turned
// to the camera rather than by the joints: joints are far noisier than the direction to the camera.
#pragma once

#include "core/camera.h"
#include "core/joints.h"
#include "perception/segment/segment.h"

namespace im2fit {

struct PersonFrame {
  Vec3f up, right, toward;  // unit, orthogonal; camera axes. `right` is the picture's right: the person's left.
  Vec3f origin_mm;          // on the floor under the person
  float camera_height_mm = 0;

  float height(Vec3f p) const { return dot(up, p) + camera_height_mm; }
  float side(Vec3f p) const { return dot(right, p - origin_mm); }
  float depth(Vec3f p) const { return dot(toward, p - origin_mm); }
};

// `floor` unknown: the camera is taken as level and heights count from the camera.
PersonFrame person_frame(const FloorPlane& floor, Vec3f centroid_mm);

}  // namespace im2fit
