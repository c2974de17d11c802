// SPDX-License-Identifier: Apache-2.0
#include "body/person_axes.h"

namespace im2fit::body {

PersonAxes::PersonAxes(const JointSet& camera_joints, const FloorPlane& floor) {
  // Of an unknown floor up is gravity's, or else the picture's, which needs no turn.
  if (floor.known || floor.up.y != -1.0F) level_ = rotation_between(half_turn(floor.up), {0, 1, 0});
  unlevel_ = transpose(level_);
  shift_ = (direction_to_mesh(camera_joints[Joint::LH]) + direction_to_mesh(camera_joints[Joint::RH])) * -0.5F;
  // Levelled, the camera is the origin and stands camera_height above the floor.
  if (floor.known) shift_.y = floor.camera_height_mm;
}

PersonAxes PersonAxes::seen_from(const Mat3f& turn, Vec3f step_mm, const FloorPlane& floor) const {
  PersonAxes out;
  // half_turn is its own inverse: a rotation between half turns is that rotation about turned axes.
  Mat3f turned = turn;
  for (const std::size_t i : {1U, 2U, 3U, 6U}) turned.m[i] = -turned.m[i];
  out.level_ = level_ * turned;
  out.shift_ = direction_to_mesh(step_mm) + shift_;
  if (floor.known) {
    out.level_ = rotation_between(out.level_ * half_turn(floor.up), {0, 1, 0}) * out.level_;
    out.shift_.y = floor.camera_height_mm;
  }
  out.unlevel_ = transpose(out.level_);
  return out;
}

JointSet PersonAxes::to_mesh(const JointSet& camera_joints) const {
  JointSet joints = camera_joints;
  for (Vec3f& p : joints.position_mm) p = to_mesh(p);
  return joints;
}

}  // namespace im2fit::body
