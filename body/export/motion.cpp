// SPDX-License-Identifier: Apache-2.0
#include "body/export/motion.h"

#include <algorithm>

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

}  // namespace im2fit::body
