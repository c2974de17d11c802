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
  paper,     // Table 1 means taken literally (spreads are standard errors: near-clones), macros only
  training,  // real spreads (NHANES/ANSUR-like), local modifiers: index and tracker
  held_out,  // evaluation: other seeds, other race mixture, mixed gender sliders, modifier groups training lacks
};

struct Subject {
  std::uint64_t seed = 0;  // of this person alone: differs between families also for the same seed and index
  Family family = Family::training;
  bool woman = false;
  body::Params params;
  MeasurementValues truth{};          // measured on the mesh, offsets included
  std::vector<Vec3f> rest_offset_mm;  // per body vertex additions the model cannot express (held_out: asymmetry,
                                      // bumps; training: smaller bumps); empty for none
};

// Deterministic: depends on the model, family, seed and index only. Even indices are men, odd ones women.
Subject draw_subject(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index);

// Whom a camera shows that is given a seed and nothing else: a woman for odd seeds, a man for even ones.
constexpr std::uint64_t subject_of_seed(std::uint64_t seed) {
  return seed % 2;
}

// The rest mesh of a subject, offsets applied; out has model.vertex_count() places.
void morph_subject(const body::BodyModel& model, const Subject& subject, std::span<Vec3f> out);

// Adults of one sex and age group: means of the paper's Table 1 (NHANES 1999-2002), its standard errors, and the
// spreads of people (NHANES: men 7.5 cm and 20 kg, women 7 cm and 20 kg).
struct AgeGroup {
  double age_low, age_high;  // years
  double share;              // of adults, 2010 census, rounded
  double stature_cm, stature_error_cm;
  double weight_kg, weight_error_kg;
};
std::span<const AgeGroup> age_groups(bool woman);

struct Build {
  double age_years = 30;
  double stature_mm = 1700;
  double weight_kg = 70;
};
// Weight is log-normal and goes with stature (correlation of the logarithm .42 men, .28 women); body mass index
// kept within 16.5..45, stature within 3 sd.
Build draw_build(Family family, bool woman, std::uint64_t person_seed);

}  // namespace im2fit::synth
