// SPDX-License-Identifier: Apache-2.0
#include "body/fit/limb_axes.h"

namespace im2fit::body {

LimbAxes limb_axes(const Pose& pose) {
  const auto x_axis = [&](Segment s) { return pose.rotation[static_cast<std::size_t>(s)] * Vec3f{1, 0, 0}; };
  Vec3f left = x_axis(Segment::pelvis);
  left.y = 0;
  left = normalized(left);
  const Vec3f forward{-left.z, 0, left.x};
  LimbAxes out{};
  auto* at = out.data();
  for (const Segment limb : kGirthLimbs) {
    const Vec3f axis = x_axis(limb);
    *at++ = dot(axis, left);
    *at++ = axis.y;
    *at++ = dot(axis, forward);
  }
  return out;
}

}  // namespace im2fit::body
