// SPDX-License-Identifier: Apache-2.0
// People who do not stand upright: no pose bows, so the rest mesh is bent.
#pragma once

#include "body/model.h"
#include "train/population/population.h"

namespace im2fit::lab {

// The subject with the trunk above the hips tilted by `bend_deg`, towards `toward_deg` (0: forwards, +90: the
// person's left). The bend spreads over the hand's breadths above the hip joints; legs stay upright, arms go where
// the pose points them. Truth measured on the mesh is left as it was.
Subject bent(const body::BodyModel& model, const Subject& subject, float bend_deg, float toward_deg);

}  // namespace im2fit::lab
