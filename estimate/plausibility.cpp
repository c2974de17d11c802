// SPDX-License-Identifier: Apache-2.0
#include "estimate/plausibility.h"

#include <algorithm>
#include <cmath>

#include "index/clothing_estimate.h"

// The thresholds of all refusals and corrections. Sources:
//   [people]  300 ordinary people of three makes (ansur, other, modifiers), condition noise, 2026-11-30: what they
//             have at most. docs/notebook/limits.md has the table, and false alarms by build and stature
//   [scenes]  the same people in scenes made wrong: floors bent, grounds raised, crowns without depth, knees bent
//   [ansur]   ANSUR II, the survey that the population is drawn from (docs/populations.md)
namespace im2fit::plausibility_limits {

// Ordinary floors have 0.02 at most, distances from the camera 0.44, a lens with k1 of 0.08 that is not undone 0.07,
// which costs 20 mm of stature; [people] [scenes]
constexpr float kFloorBendMax = 0.05F;
// Ordinary people have 15 at most; 24 cost 20 mm of stature, and bends beyond 30 are fitted within 5; [people]
// [scenes]
constexpr float kKneesBentMaxDeg = 24;
// kSeenStature..Mm: the survey's smallest woman has 1409 mm and its tallest man 1993. Beyond 2100 statures read too
// small by 10 mm and more; [ansur] [scenes]
// The crown stands so far above the height below which 500 mm^2 of the outline lie: mean of people, SD 6; [people]
constexpr float kCrownAboveMm = 22;
constexpr std::size_t kCrownOf500Mm2 = 1;  // of ProfileLayout's crown values

// Noise lifts a floor by 2 at most, shoes and feet have no level of this share; [people]
constexpr float kGroundMinMm = 15, kGroundMaxMm = 250;
constexpr float kGroundShareMin = 0.35F;

// Soles are less clear against a ground of their own: the statures of 30 on plates of 25 to 165 mm read so much too
// tall, and two SD of it; [scenes]
constexpr float kRaisedTooTallMm = 5, kRaisedTwoSdMm = 12;

// Toes lie 110 to 185 in front of the shin of 24 people as they are, 137 to 210 of 24 in shoes and clothes, 53 to 125
// of 24 with heels raised by 50 to 95, up to 141 of 12 others. Less three times the ankle's front, which tells how
// the shin leans: 131 and more against 29 to 114. Those 24 read 33 to 66 too tall; [people] [scenes]
constexpr float kToeReachStatureMm = 1700;  // of the figures
constexpr float kToeReachMin = 145, kToeReachOfLeanMin = 115, kReachALean = 3;
constexpr float kHeelsTooTallMm = 48, kHeelsTwoSdMm = 30;

// Crowns have up to 0.55, and up to 0.45 of the pixels above them are lost; [people]. Where the background is not
// seen either, lost pixels mean nothing.
constexpr float kFlatMin = 0.5F, kFlatAloneMin = 0.62F;
constexpr float kLostMin = 0.5F;
// A crown flatter than any seen whole needs fewer lost pixels: four of 12 had 0.42 to 0.49 and 0.62 to 0.77; [scenes]
constexpr float kFlatSureMin = 0.6F, kLostOfFlatMin = 0.4F;
// The fit closes the head or follows the edge. The mean that the stature then lacks, and two SD of it; [scenes]
constexpr float kClosedAboveMm = 60;
constexpr float kClosedMissingMm = 9, kClosedTwoSdMm = 14;
constexpr float kFollowedMissingMm = 40, kFollowedTwoSdMm = 22;

// The answer's stature less the crown as seen: -10 to 12 of 24 people as they are, -62 to -10 of 24 in clothes, shoes
// and hair. Of 19 in a skirt to the floor over shoes, which the fit takes for legs, it is -147 to 67; of a crown
// whose loss was not noticed, 34. Both then stand in the interval, with two SD of soles and hair and of such a crown;
// [scenes]. A crown far above the fitted body may be a hat: the value stays.
constexpr float kOverSeenMaxMm = 24, kOverSeenClothedMaxMm = 12, kUnderSeenMaxMm = 80;
constexpr float kWornMostMm = 65, kSeenTwoSdMm = 15, kAnswerTwoSdMm = 40;

}  // namespace im2fit::plausibility_limits

namespace im2fit {

using namespace plausibility_limits;

namespace {

constexpr GuidanceSet bit_of(Guidance code) {
  return static_cast<GuidanceSet>(code);
}

// The angle between a thigh's and a shank's direction, without a libm: of less than 90 degrees to 0.3 degrees.
float bend_deg(const body::PosedSkeleton& bones, body::Segment thigh) {
  const auto upper = static_cast<std::size_t>(thigh), lower = upper + 1;
  const Vec3f a = normalized(bones.tail[upper] - bones.head[upper]);
  const Vec3f b = normalized(bones.tail[lower] - bones.head[lower]);
  // Half of the angle by the half chord: x + x^3 / 6 + 3 x^5 / 40 + 15 x^7 / 336.
  const float x = 0.5F * norm(a - b), x2 = x * x;
  const float half = x * (1 + x2 * (1.0F / 6 + x2 * (3.0F / 40 + x2 * (15.0F / 336))));
  constexpr float kDegrees = 57.29578F;
  return 2 * kDegrees * half;
}

float seen_stature(const Fuser::Description& described) {
  return described.feature[kPaperFeatureSize + static_cast<std::size_t>(ProfileLayout::kCrown) + kCrownOf500Mm2] +
         kCrownAboveMm;
}

// Feet are as long as people are tall.
bool heels_raised(const SurroundingsSigns& signs, float seen_stature_mm) {
  const float scale = kToeReachStatureMm / seen_stature_mm;
  const float reach = signs.toe_reach_mm * scale;
  return signs.feet_known && reach < kToeReachMin &&
         reach - kReachALean * scale * signs.ankle_ahead_mm < kToeReachOfLeanMin;
}

bool crown_lost(const SurroundingsSigns& signs, float flatness) {
  const bool tells = signs.lost_beside_share < kLostMin;
  if (!signs.above_known) return false;
  if (tells && flatness > kFlatSureMin && signs.lost_above_share > kLostOfFlatMin) return true;
  return signs.lost_above_share > kLostMin && flatness > (tells ? kFlatMin : kFlatAloneMin);
}

}  // namespace

FittedStance stance_of(const body::PosedSkeleton& bones, std::span<const Vec3f> points, const FloorPlane& floor) {
  FittedStance stance;
  stance.knees_deg =
      0.5F * (bend_deg(bones, body::Segment::left_upper_leg) + bend_deg(bones, body::Segment::right_upper_leg));
  float crown = -std::numeric_limits<float>::max();
  for (const Vec3f& p : points) crown = std::max(crown, dot(floor.up, p) + floor.camera_height_mm);
  if (!points.empty()) stance.crown_mm = crown;
  return stance;
}

float ground_of(const SurroundingsSigns& signs) {
  const bool level = signs.ground_known && signs.ground_share >= kGroundShareMin &&
                     signs.floor_share < signs.ground_share && signs.ground_mm >= kGroundMinMm &&
                     signs.ground_mm <= kGroundMaxMm;
  // A bent floor is above itself in places.
  const bool flat = !signs.floor.known || std::fabs(signs.floor.bend) <= kFloorBendMax;
  return level && flat ? signs.ground_mm : 0;
}

Plausibility judge(const SurroundingsSigns& signs, const Fuser::Description& described, const FittedStance& stance) {
  Plausibility out;
  if (signs.floor.known) out.floor_bend = signs.floor.bend;
  out.knees_deg = stance.knees_deg;
  out.seen_stature_mm = seen_stature(described);
  out.ground_mm = ground_of(signs);
  // What spoils all other numbers comes first.
  if (std::fabs(out.floor_bend) > kFloorBendMax) {
    out.refused = bit_of(Guidance::floor_bent);
    return out;
  }
  if (out.knees_deg > kKneesBentMaxDeg) {
    out.refused = bit_of(Guidance::not_upright);
    return out;
  }
  const bool lost = crown_lost(signs, described.crown_flatness);
  if (lost) {
    const float closed_mm = stance.crown_mm - (out.seen_stature_mm - kCrownAboveMm);
    out.crown_missing_mm = closed_mm > kClosedAboveMm ? kClosedMissingMm : kFollowedMissingMm;
  }
  // A short person whose hair gives no depth is not refused for it.
  if (out.seen_stature_mm + out.crown_missing_mm < kSeenStatureMinMm || out.seen_stature_mm > kSeenStatureMaxMm) {
    out.refused = bit_of(Guidance::out_of_population);
    return out;
  }
  if (out.ground_mm == 0 && heels_raised(signs, out.seen_stature_mm)) out.heels_mm = kHeelsTooTallMm;
  if (out.ground_mm > 0 || out.heels_mm > 0) out.beside |= bit_of(Guidance::feet_raised);
  if (lost) out.beside |= bit_of(Guidance::head_unseen);
  return out;
}

namespace {

// What the body fitted says against what is seen.
void reconcile(float seen_mm, bool clothed, index::IntervalEstimate& stature) {
  const float over = stature.value - seen_mm;
  const bool above = over > (clothed ? kOverSeenClothedMaxMm : kOverSeenMaxMm);
  if (!above && !(over < -kUnderSeenMaxMm)) return;
  const float highest = seen_mm + (above ? kFollowedMissingMm + kFollowedTwoSdMm : kSeenTwoSdMm);
  stature.low = std::min({stature.low, stature.value - kAnswerTwoSdMm, seen_mm - kWornMostMm});
  stature.high = std::max(stature.high, highest);
  if (above) stature.value = 0.5F * (stature.value + seen_mm);
}

}  // namespace

void correct(const Plausibility& plausibility, index::Answer& answer) {
  index::IntervalEstimate& stature = answer.measurements[measurement_index(Measurement::stature)];
  // A crown that is known to lack is counted below.
  if (!has(plausibility.beside, Guidance::head_unseen))
    reconcile(plausibility.seen_stature_mm, index::looks_dressed(answer, ClothingGiven::unknown), stature);
  if (plausibility.heels_mm > 0) {
    stature.value -= plausibility.heels_mm;
    stature.low -= plausibility.heels_mm + kHeelsTwoSdMm;
    stature.high -= plausibility.heels_mm - kHeelsTwoSdMm;
  } else if (has(plausibility.beside, Guidance::feet_raised)) {
    stature.value -= kRaisedTooTallMm;
    stature.low -= kRaisedTooTallMm + kRaisedTwoSdMm;
  }
  if (!has(plausibility.beside, Guidance::head_unseen)) return;
  const bool closed = plausibility.crown_missing_mm < kFollowedMissingMm;
  stature.value += plausibility.crown_missing_mm;
  stature.high += plausibility.crown_missing_mm + (closed ? kClosedTwoSdMm : kFollowedTwoSdMm);
}

}  // namespace im2fit
