// SPDX-License-Identifier: Apache-2.0
// Whether a gap between the arms and the trunk is visible: background, or a step in depth. A section through trunk
// and arm as one piece does not measure the trunk, and joints cannot detect it: hands err by 100 mm.
#pragma once

#include "core/camera.h"
#include "core/guidance.h"
#include "core/joints.h"

namespace im2fit {

// The arms that touch the trunk, lie before it or hide its outline at the waist or at the hips. `mask` of the person
// in `depth`, seen from the front or from behind; `joints` of that person. Each arm is judged by itself:
//   - a gap in half of the rows of both bands: apart;
//   - a gap at the waist, none at the hips, and the lowest gap is wide, so that the hand ends beside them: apart;
//   - no gap at the waist, but an arm stretched out sideways above it: apart;
//   - a band that is not in the picture is not judged;
//   - anything else: joined.
// No allocation, thread-safe; + - * / sqrt only. Reads some 35 rows from the spine outwards.
ArmSet arms_joined(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const JointSet& joints);

}  // namespace im2fit
