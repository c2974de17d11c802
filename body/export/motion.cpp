// SPDX-License-Identifier: Apache-2.0
#include "body/export/motion.h"

#include <algorithm>
#include <cmath>

#include "body/export/figure.h"

namespace im2fit::body {

Pose on_lower_sole(const Skeleton& rest, float floor_rest_mm, Pose pose) {
  const PosedSkeleton posed = pose_skeleton(rest, pose);
  const auto sole_mm = [&](Segment foot) {
    const auto s = static_cast<std::size_t>(foot);
    return posed.head[s].y - (rest.head[s].y - floor_rest_mm);
  };
  pose.translation_mm.y -= std::min(sole_mm(Segment::left_foot), sole_mm(Segment::right_foot));
  return pose;
}

Status check_ascending(std::span<const PoseKey> keys) {
  bool good = !keys.empty();
  for (std::size_t i = 1; i < keys.size(); ++i)
    good = good && static_cast<float>(keys[i - 1].time_s) < static_cast<float>(keys[i].time_s);
  if (good) return Ok{};
  return Error{ErrorCode::invalid_argument, "a motion needs poses at ascending times"};
}

namespace {

// Unit quaternion x, y, z, w of a rotation, from the largest of the four (no division by small numbers).
std::array<float, 4> quaternion(const Mat3f& r) {
  const auto& m = r.m;
  const std::array<float, 4> squares = {1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8], 1 - m[0] - m[4] + m[8],
                                        1 + m[0] + m[4] + m[8]};
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) best = squares[i] > squares[best] ? i : best;
  std::array<float, 4> q{};
  if (best == 0) q = {squares[0], m[1] + m[3], m[2] + m[6], m[7] - m[5]};
  if (best == 1) q = {m[1] + m[3], squares[1], m[5] + m[7], m[2] - m[6]};
  if (best == 2) q = {m[2] + m[6], m[5] + m[7], squares[2], m[3] - m[1]};
  if (best == 3) q = {m[7] - m[5], m[2] - m[6], m[3] - m[1], squares[3]};
  const float n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (float& c : q) c /= n;
  return q;
}

}  // namespace

RigPose rig_pose(const Skeleton& rest, const Pose& pose) {
  RigPose rig;
  rig.root_m = (rest.head[0] + pose.translation_mm) * kMetres;
  for (std::size_t s = 0; s < rig.rotation.size(); ++s) rig.rotation[s] = quaternion(local_rotation(pose, s));
  return rig;
}

Pose standing_pose(const Skeleton& rest, float floor_rest_mm, const JointSet& joints) {
  return on_lower_sole(rest, floor_rest_mm, pose_from_joints(rest, joints));
}

RigPose rig_of_joints(const Skeleton& rest, float floor_rest_mm, const JointSet& joints) {
  return rig_pose(rest, standing_pose(rest, floor_rest_mm, joints));
}

}  // namespace im2fit::body
