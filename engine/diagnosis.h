// SPDX-License-Identifier: Apache-2.0
// Why frames show no person: their values, their rotation, their intrinsics.
#pragma once

#include "core/camera.h"
#include "hal/depth_diagnosis.h"
#include "perception/joints/tracker.h"

namespace im2fit {

// Of an upright picture as pushed. `joint_model`: of several units that make a room, the one in which a person of
// usual height is found is named; null: the likeliest. Some tenths of a second where the unit is in question.
// Allocates.
hal::DepthDiagnosis diagnose(DepthView depth, const Intrinsics& intrinsics, const JointModel* joint_model);

}  // namespace im2fit
