// SPDX-License-Identifier: Apache-2.0
// Between a camera's axes (x right, y down, z forward) and those of meshes (x the left of a person facing the camera,
// y up, z towards the camera): a half turn about x, then the up direction, by the floor or by gravity, to +y. The
// origin lies between the hips; with a known floor, on it. mm. + - * / and sqrt only: the same bits everywhere.
#pragma once

#include "body/skeleton.h"
#include "core/floor_plane.h"
#include "core/joints.h"

namespace im2fit::body {

class PersonAxes {
 public:
  PersonAxes() = default;
  PersonAxes(const JointSet& camera_joints, const FloorPlane& floor);

  // Of another camera, whose directions become this one's by `turn` and whose points then by `step_mm`. `floor` as
  // that camera sees it, where known, is the floor of these axes: a camera's pose is told less exactly.
  PersonAxes seen_from(const Mat3f& turn, Vec3f step_mm, const FloorPlane& floor) const;

  Vec3f to_mesh(Vec3f camera) const { return direction_to_mesh(camera) + shift_; }
  Vec3f direction_to_mesh(Vec3f camera) const { return level_ * half_turn(camera); }
  Vec3f to_camera(Vec3f mesh) const { return direction_to_camera(mesh - shift_); }
  Vec3f direction_to_camera(Vec3f mesh) const { return half_turn(unlevel_ * mesh); }
  Vec3f camera() const { return shift_; }  // where it stands
  JointSet to_mesh(const JointSet& camera_joints) const;

 private:
  static Vec3f half_turn(Vec3f v) { return {v.x, -v.y, -v.z}; }
  Mat3f level_, unlevel_;
  Vec3f shift_;
};

}  // namespace im2fit::body
