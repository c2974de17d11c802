// SPDX-License-Identifier: Apache-2.0
// The body of the measured person, posed as the camera sees the person now.
#pragma once

#include "body/export/export.h"
#include "body/export/motion.h"
#include "body/skeleton.h"
#include "core/joints.h"
#include "core/status.h"
#include "perception/segment/segment.h"

namespace im2fit::apps {

class AvatarAnimator {
 public:
  // Errors: as make_figure().
  static Result<AvatarAnimator> create(const body::Avatar& avatar);
  // Of finite joints in camera axes. In the axes of the .glb, hips above the origin, the lower foot on y = 0.
  body::Pose pose(const JointSet& joints, const FloorPlane& floor) const;
  body::RigPose rig(const body::Pose& pose) const { return body::rig_pose(rest_, pose); }

 private:
  body::Skeleton rest_;
  float floor_mm_ = 0;  // under the rest skeleton
};

// The joints themselves in those axes, metres.
std::array<Vec3f, kJointCount> standing_joints_m(const JointSet& joints, const FloorPlane& floor);

}  // namespace im2fit::apps
