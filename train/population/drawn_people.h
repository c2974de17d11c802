// SPDX-License-Identifier: Apache-2.0
// People drawn by number: the same number gives the same body on every machine, so that an index need not store
// bodies (docs/formats-index.md).
#pragma once

#include <cstdint>
#include <span>

#include "body/model.h"
#include "body/warp.h"
#include "core/rng.h"
#include "core/status.h"

namespace im2fit::body {

enum class Family {
  paper,     // Table 1 means taken literally (spreads are standard errors: near-clones), macros only
  training,  // real spreads (NHANES), proportions of measured people (ANSUR II), local modifiers: index and tracker
  held_out,  // evaluation: other seeds, other race mixture, mixed gender sliders, modifier groups training lacks
};

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

// Dimensions as they go together in measured people (ANSUR II) of this stature, weight and age, as the warp that
// gives them to a rest mesh without one.
// `tape_share`: the section's share of the tape's excess over the ellipse of a calliper's breadth and depth, at waist
// and hips; 1: the tape is right, 0: the callipers are. `girth_sd`: spread of the trunk's girths beyond people's, as
// a share of them.
Warp draw_warp(const BodyModel& model, bool woman, const Build& build, Rng& rng, std::span<const Vec3f> rest,
               double tape_share = 1, double girth_sd = 0);

// One person of a family, without measurements. Deterministic: depends on the model, family, seed and number only.
// Even numbers are men, odd ones women.
struct Drawn {
  std::uint64_t seed = 0;  // of this person alone: differs between families also for the same seed and number
  bool woman = false;
  Params params;
};
Drawn draw_person(const BodyModel& model, Family family, std::uint64_t seed, std::uint64_t number);

// Raise when draw_person changes: an index of other people is then refused instead of misread.
inline constexpr std::uint32_t kPopulationVersion = 4;
// A person of the training family as an index names it. Error: the version is not this one. A few milliseconds.
Result<Params> params_of_person(const BodyModel& model, std::uint32_t version, std::uint64_t seed,
                                std::uint64_t number);
// The same person's age alone, years. Less than a microsecond.
Result<float> age_of_person(std::uint32_t version, std::uint64_t seed, std::uint64_t number);

}  // namespace im2fit::body
