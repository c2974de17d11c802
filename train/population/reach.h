// SPDX-License-Identifier: Apache-2.0
// Arms that reach for a point: two bones, the elbow where it stays outside the body.
#pragma once

#include <functional>

#include "core/vec3.h"

namespace im2fit::lab {

struct Reach {
  Vec3f upper;  // unit directions
  Vec3f lower;
};
// From `shoulder` with bones of these lengths to `wrist` (brought within reach along the line). The elbow turns
// about the line: near `elbow_hint` unless depth_inside (mm a point is inside the body) speaks against it.
Reach reach_for(Vec3f shoulder, float upper_mm, float lower_mm, Vec3f wrist, Vec3f elbow_hint,
                const std::function<float(Vec3f)>& depth_inside);

}  // namespace im2fit::lab
