// SPDX-License-Identifier: Apache-2.0
// An avatar over time, as files other programs play (docs/motion.md). Errors: the avatar names no model; there are no
// keys, or their times do not ascend; a .bvh would have more than a million frames; the file cannot be written.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "body/export/export.h"
#include "body/skeleton.h"

namespace im2fit::body {

struct PoseKey {
  double time_s = 0;  // the first is 0; ascending
  Pose pose;          // of the avatar's skeleton, mesh axes
};

// `pose` raised or lowered until the lower sole is on y = 0; soles are level in a pose from joints, so each is as far
// below its ankle as at rest. `floor_rest_mm`: under the rest skeleton, Figure::floor_rest.
Pose on_lower_sole(const Skeleton& rest, float floor_rest_mm, Pose pose);

// Error: no keys, or their times do not ascend, as floats, which is what .glb holds.
Status check_ascending(std::span<const PoseKey> keys);

// As glb_of, with one animation: the root's translation and the rotation of each segment at the keys' times, linear
// between them. avatar.pose is the pose of the nodes, as in a still avatar.
Result<std::vector<std::byte>> animated_glb_of(const Avatar& avatar, std::span<const PoseKey> keys);
Status write_glb(const Avatar& avatar, std::span<const PoseKey> keys, const std::string& path);
// As write_bvh, with frames of equal length: the keys' median distance; each frame shows the latest key that is no
// more than half of it ahead.
Status write_bvh(const Avatar& avatar, std::span<const PoseKey> keys, const std::string& path);

inline constexpr float kMetres = 1e-3F;  // of mm

// The nodes of an avatar's .glb in a pose: a viewer may set them in every frame. Of nodes 0 to 18, the segments in
// order (docs/formats-body.md).
struct RigPose {
  Vec3f root_m;                                              // translation of node 0; the others keep theirs
  std::array<std::array<float, 4>, kSegmentCount> rotation;  // unit quaternions x, y, z, w, relative to the parent
};
// `pose`: of the avatar with the rest skeleton `rest`.
RigPose rig_pose(const Skeleton& rest, const Pose& pose);
// The pose given by `joints`, in mesh axes, the lower foot on y = 0. `floor_rest_mm`: Figure::floor_rest.
Pose standing_pose(const Skeleton& rest, float floor_rest_mm, const JointSet& joints);
RigPose rig_of_joints(const Skeleton& rest, float floor_rest_mm, const JointSet& joints);

}  // namespace im2fit::body
