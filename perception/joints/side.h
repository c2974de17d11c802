// SPDX-License-Identifier: Apache-2.0
// Front or back. The cascade names joints as if every person faced the camera (left is where x is larger); trees over
// shape-indexed depth differences decide whether that is so: toes, nose, knees and buttocks point in one direction.
#pragma once

#include <cstdint>

#include "core/joints.h"
#include "perception/joints/model_data.h"

namespace im2fit::joints {

// Log-odds of the back being towards the camera, in 1/256; 0 when the model has no trees for it.
int side_score(const JointModel::Data& model, const View& view, const Shape& shape);
// The chance that goes with it, 0..1.
float chance_of_score(int score);
// Left for right.
void swap_sides(JointSet& joints);

}  // namespace im2fit::joints
