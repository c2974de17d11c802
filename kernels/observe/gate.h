// SPDX-License-Identifier: Apache-2.0
// Whether a sighting may be measured, and if not, what the person should change.
#pragma once

#include "kernels/core/guidance.h"
#include "kernels/core/joints.h"
#include "kernels/segment/segment.h"

namespace im2fit {

// not_upright (mended Eq. 1 and the floor), not_frontal, arms_close. Thresholds sit three joint errors away from what
// a person asked to stand straight does: one noisy joint must not refuse a good frame.
GuidanceSet pose_gate(const JointSet& joints, const FloorPlane& floor);

}  // namespace im2fit
