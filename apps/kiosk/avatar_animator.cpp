// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/avatar_animator.h"

#include <algorithm>
#include <array>

#include "body/export/figure.h"
#include "person/avatar.h"

namespace im2fit::apps {

Result<AvatarAnimator> AvatarAnimator::create(const body::Avatar& avatar) {
  const auto figure = body::make_figure(avatar);
  if (!figure) return figure.error();
  AvatarAnimator animator;
  animator.rest_ = figure->skeleton;
  animator.floor_mm_ = figure->floor_rest;
  return animator;
}

body::Pose AvatarAnimator::pose(const JointSet& joints, const FloorPlane& floor) const {
  return body::standing_pose(rest_, floor_mm_, to_mesh_axes(joints, floor));
}

std::array<Vec3f, kJointCount> standing_joints_m(const JointSet& joints, const FloorPlane& floor) {
  constexpr float kAnkleMm = 80;  // of a foot whose floor is not seen
  const JointSet standing = to_mesh_axes(joints, floor);
  const float up_mm = floor.known ? 0 : kAnkleMm - std::min(standing[Joint::LF].y, standing[Joint::RF].y);
  std::array<Vec3f, kJointCount> out;
  for (std::size_t j = 0; j < kJointCount; ++j)
    out[j] = (standing.position_mm[j] + Vec3f{0, up_mm, 0}) * body::kMetres;
  return out;
}

}  // namespace im2fit::apps
