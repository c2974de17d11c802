// SPDX-License-Identifier: Apache-2.0
// How likely it is that what was found is somebody: by its shape, by how sure its joints are, and by their skeleton.
#pragma once

#include "kernels/core/joints.h"

namespace im2fit {

// Log-odds from one frame. `shape_odds`: Segmenter::shape_odds; 0: not known. `likeness`: JointTracker's.
float somebody_odds(float shape_odds, float likeness, const JointSet& joints);

}  // namespace im2fit
