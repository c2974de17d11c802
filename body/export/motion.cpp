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

Status check_ascending(std::span<const PoseKey> keys) {
  bool good = !keys.empty();
  for (std::size_t i = 1; i < keys.size(); ++i)
    good = good && static_cast<float>(keys[i - 1].time_s) < static_cast<float>(keys[i].time_s);
  if (good) return Ok{};
  return Error{ErrorCode::invalid_argument, "a motion needs poses at ascending times"};
}

}  // namespace im2fit::body
