// SPDX-License-Identifier: Apache-2.0
// Bones of a morphed mesh, poses, linear blend skinning, and the fifteen joints.
#pragma once

#include <array>
#include <span>

#include "body/model.h"

namespace im2fit::body {

struct Mat3f {
  std::array<float, 9> m = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
};
inline Vec3f operator*(const Mat3f& a, Vec3f v) {
  return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
          a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}
Mat3f operator*(const Mat3f& a, const Mat3f& b);
Mat3f transpose(const Mat3f& a);
// Smallest rotation taking the direction `from` to `to` (sqrt only, no trigonometry: same bits everywhere).
Mat3f rotation_between(Vec3f from, Vec3f to);
// Workstation use (trigonometry): rotation by `degrees` about a unit axis.
Mat3f rotation_about(Vec3f axis, float degrees);

// Rest-pose bones of one person.
struct Skeleton {
  std::array<Vec3f, kSegmentCount> head;  // where the segment turns
  std::array<Vec3f, kSegmentCount> tail;  // its far end (head of the child, crown, finger root, toe)
};
Skeleton rest_skeleton(const BodyModel& model, std::span<const Vec3f> rest_vertices);

// Rotation of each segment in mesh axes relative to rest (not to its parent), and the pelvis' displacement.
struct Pose {
  std::array<Mat3f, kSegmentCount> rotation;
  Vec3f translation_mm;
};
// Composes parent-relative rotations along the chain.
Pose pose_from_local(const std::array<Mat3f, kSegmentCount>& local, Vec3f translation_mm = {});
// Pose whose bones point from joint to joint. Joints in mesh axes (y up, mm).
Pose pose_from_joints(const Skeleton& rest, const JointSet& joints);
// Named poses. `spread_deg`: arm abduction of relaxed (10-22 by girth: relaxed_spread_deg in measure.h).
Pose relaxed_pose(const Skeleton& rest, float spread_deg);
Pose a_pose(const Skeleton& rest);  // the rest pose
Pose psi_pose(const Skeleton& rest);
Pose arms_out_pose(const Skeleton& rest);

struct PosedSkeleton {
  std::array<Vec3f, kSegmentCount> head;
  std::array<Vec3f, kSegmentCount> tail;
};
PosedSkeleton pose_skeleton(const Skeleton& rest, const Pose& pose);

// out has as many places as rest_vertices. No allocation.
void skin(const BodyModel& model, std::span<const Vec3f> rest_vertices, const Skeleton& rest, const Pose& pose,
          std::span<Vec3f> out);

// OpenNI's fifteen, in mesh axes, of a posed mesh made by skin() (joint cubes are skinned with it; confidence 1).
JointSet joints_of(const BodyModel& model, std::span<const Vec3f> posed_vertices);

}  // namespace im2fit::body
