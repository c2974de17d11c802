// SPDX-License-Identifier: Apache-2.0
// The sliders that give a stature and a mass.
#pragma once

#include "body/model.h"

namespace im2fit::body {

// Sets params.height and params.weight (at its end: adds the fatness set of docs/makehuman.md to params.modifiers) so
// that the rest mesh has this stature and mass, to 0.1 mm and 0.01 kg. False when out of reach (params then hold the
// nearest). The slider's reach grows as muscle falls: give heavy people low muscle. About a millisecond.
bool solve_stature_and_weight(const BodyModel& model, Params& params, double stature_mm, double weight_kg);

}  // namespace im2fit::body
