// SPDX-License-Identifier: Apache-2.0
// Who stands before the virtual camera. Index and evaluation families differ in shape, not only in seed.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "kernels/core/measurement.h"

namespace im2fit::synth {

enum class Family {
  paper,      // Table 1 means taken literally (spreads are standard errors: near-clones), macros only
  training,   // real spreads (NHANES/ANSUR-like), local modifiers: index and tracker
  held_out,   // evaluation: other seeds, other race mixture, mixed gender sliders, modifier groups training lacks
};

struct Subject {
  std::uint64_t seed = 0;
  Family family = Family::training;
  bool woman = false;
  body::Params params;
  MeasurementValues truth{};  // measured on the mesh
  std::vector<Vec3f> rest_offset_mm;  // per body vertex additions the model cannot express (held_out: asymmetry,
                                      // bumps); empty for none
};

// Deterministic: depends on the model, family, seed and index only.
Subject draw_subject(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index);

// The rest mesh of a subject, offsets applied.
void morph_subject(const body::BodyModel& model, const Subject& subject, std::span<Vec3f> out);

}  // namespace im2fit::synth
