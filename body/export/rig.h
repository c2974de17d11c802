// SPDX-License-Identifier: Apache-2.0
// How the nodes of an avatar's .glb stand in a pose: who shows the file may set them anew with every frame.
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
// `pose` of the avatar whose rest skeleton that is.
RigPose rig_pose(const Skeleton& rest, const Pose& pose);
// Of whoever stands as these joints say, in mesh axes, the lower foot on y = 0. `floor_rest_mm`: Figure::floor_rest.
Pose standing_pose(const Skeleton& rest, float floor_rest_mm, const JointSet& joints);
RigPose rig_of_joints(const Skeleton& rest, float floor_rest_mm, const JointSet& joints);

}  // namespace im2fit::body
