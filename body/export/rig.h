// SPDX-License-Identifier: Apache-2.0
// The nodes of an avatar's .glb in a pose: a viewer may set them in every frame.
#pragma once

#include <array>

#include "body/skeleton.h"

namespace im2fit::body {

inline constexpr float kMetres = 1e-3F;  // of mm

// Of nodes 0 to 18, the segments in order (docs/formats-body.md).
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
