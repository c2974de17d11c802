// SPDX-License-Identifier: Apache-2.0
// Whether a measurement may be believed: the one place where an answer is refused, doubted or corrected because of
// who stands there, how, on what, and before which camera. The frames' own guidance (perception) has let all of it
// pass.
//
//   code                what shows it                                    what follows
//   FLOOR_BENT          the floor is a bowl (observe/floor_bend.h)       no answer
//   NOT_UPRIGHT         both knees of the fitted pose are bent           no answer
//   OUT_OF_POPULATION   crown over floor as seen, before people count    no answer
//   FEET_RAISED         the ground about the feet is level, above floor  heights count from that ground
//   FEET_RAISED         toes are too near the shin for flat feet: heels  stature lowered, interval wider
//   HEAD_UNSEEN         the head ends flat below pixels without depth    stature raised, interval wider upwards
//   none                the fitted stature is not that of the crown      both in the stature's interval
#pragma once

#include <limits>

#include "body/fit/shape_fitter.h"
#include "core/guidance.h"
#include "index/index.h"
#include "perception/observe/observe.h"

namespace im2fit {

// What statures the models hold.
inline constexpr float kSeenStatureMinMm = 1400, kSeenStatureMaxMm = 2100;

// How the body fitted to the front stands. Not a number without a fit.
struct FittedStance {
  float knees_deg = std::numeric_limits<float>::quiet_NaN();  // bend of the knees, mean of both
  float crown_mm = std::numeric_limits<float>::quiet_NaN();   // over the floor
};
// `points`: of the fit, camera axes; `bones` of the same, levelled.
FittedStance stance_of(const body::PosedSkeleton& bones, std::span<const Vec3f> points, const FloorPlane& floor);

// Plain data. Numbers that are not known are not numbers.
struct Plausibility {
  GuidanceSet refused = 0;  // codes that refuse the answer
  GuidanceSet beside = 0;   // codes beside an answer
  float floor_bend = std::numeric_limits<float>::quiet_NaN();
  float knees_deg = std::numeric_limits<float>::quiet_NaN();
  float seen_stature_mm = std::numeric_limits<float>::quiet_NaN();
  float ground_mm = 0;         // of the ground that the feet stand on, above the floor, where it counts
  float heels_mm = 0;          // by which raised heels make taller, about; 0 where none are seen
  float crown_missing_mm = 0;  // added to the stature
};

// What the feet stand on, above the floor: 0 unless a level ground about them is seen.
float ground_of(const SurroundingsSigns& signs);

// Of a front that was described with ground_of(signs).
Plausibility judge(const SurroundingsSigns& signs, const Fuser::Description& described, const FittedStance& stance);

// The answer corrected for what does not refuse it.
void correct(const Plausibility& plausibility, index::Answer& answer);

}  // namespace im2fit
