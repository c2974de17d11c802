// SPDX-License-Identifier: Apache-2.0
// People unlike the index' population, to fit its intervals on: a training subject changed by modifiers and bumps
// that neither the training nor the held-out family uses. Not the held-out family, which is for the evaluation alone.
#pragma once

#include <cstdint>

#include "body/model.h"
#include "synth/population.h"

namespace im2fit::synth {

// Deterministic: depends on the model, seed and index only. `family` says training; truth is measured on the mesh.
Subject draw_stranger(const body::BodyModel& model, std::uint64_t seed, std::uint64_t index);
// The same; `rest` becomes what morph_subject() would make of it.
Subject draw_stranger(const body::BodyModel& model, std::uint64_t seed, std::uint64_t index,
                      std::vector<Vec3f>& rest);

}  // namespace im2fit::synth
