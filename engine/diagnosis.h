// SPDX-License-Identifier: Apache-2.0
// Finds out why no person is found: wrong values, rotation or intrinsics.
#pragma once

#include "core/camera.h"
#include "hal/depth_diagnosis.h"
#include "perception/joints/tracker.h"

namespace im2fit {

// Takes an upright picture as pushed. If several units give a plausible room, `joint_model` is used to select the
// unit in which a person of usual height is found; null: the most likely unit. Takes some tenths of a second if the
// unit is uncertain. Allocates.
hal::DepthDiagnosis diagnose(DepthView depth, const Intrinsics& intrinsics, const JointModel* joint_model);

}  // namespace im2fit
