// SPDX-License-Identifier: Apache-2.0
// Each decision of estimate/plausibility.h on either side of its threshold; rendered people:
// tests/apps/limits_test.cpp.
#include "estimate/plausibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

namespace im2fit {
namespace {

constexpr auto kCrown = kPaperFeatureSize + static_cast<std::size_t>(ProfileLayout::kCrown) + 1;
constexpr float kCrownAbove = 22;  // docs/notebook/limits.md

// An ordinary person on an ordinary floor.
struct Seen {
  SurroundingsSigns signs;
  Fuser::Description described;
  FittedStance stance;
  Seen() {
    signs.floor = {true, 0.002F};
    signs.ground_known = signs.above_known = true;
    signs.ground_mm = 1;
    signs.ground_share = signs.floor_share = 0.7F;
    signs.lost_above_share = signs.lost_beside_share = 0.2F;
    described.feature[kCrown] = 1700;
    described.crown_flatness = 0.45F;
    stance.knees_deg = 8;
    stance.crown_mm = 1715;
  }
  Plausibility judged() const { return judge(signs, described, stance); }
};

GuidanceSet only(Guidance code) {
  return static_cast<GuidanceSet>(code);
}

TEST(Plausibility, AnOrdinaryPersonHasNoCode) {
  const Plausibility judged = Seen().judged();
  EXPECT_EQ(judged.refused, 0U);
  EXPECT_EQ(judged.beside, 0U);
  EXPECT_EQ(judged.ground_mm, 0);
  EXPECT_EQ(judged.crown_missing_mm, 0);
  EXPECT_FLOAT_EQ(judged.seen_stature_mm, 1700 + kCrownAbove);
}

TEST(Plausibility, ABentFloorRefusesFirst) {
  for (const float bend : {0.44F, 0.06F, -0.06F}) {
    Seen seen;
    seen.signs.floor.bend = bend;
    seen.stance.knees_deg = 60;
    EXPECT_EQ(seen.judged().refused, only(Guidance::floor_bent)) << bend;
    EXPECT_FLOAT_EQ(seen.judged().floor_bend, bend);
  }
  Seen seen;
  seen.signs.floor.bend = 0.04F;
  EXPECT_EQ(seen.judged().refused, 0U);
  seen.signs.floor = {false, 0.44F};
  EXPECT_EQ(seen.judged().refused, 0U) << "no floor was judged";
}

TEST(Plausibility, BentKneesAreNotUpright) {
  Seen seen;
  seen.stance.knees_deg = 29;
  EXPECT_EQ(seen.judged().refused, only(Guidance::not_upright));
  seen.stance.knees_deg = 19;
  EXPECT_EQ(seen.judged().refused, 0U);
  seen.stance.knees_deg = std::nanf("");
  EXPECT_EQ(seen.judged().refused, 0U) << "no body was fitted";
}

TEST(Plausibility, StaturesThatNoModelHoldsAreRefused) {
  for (const auto& [crown, refused] :
       {std::pair(1370.0F, true), {1390.0F, false}, {2070.0F, false}, {2090.0F, true}}) {
    Seen seen;
    seen.described.feature[kCrown] = crown;
    EXPECT_EQ(seen.judged().refused, refused ? only(Guidance::out_of_population) : 0U) << crown;
  }
}

TEST(Plausibility, ALevelGroundAboveTheFloorIsWhereHeightsCountFrom) {
  Seen seen;
  seen.signs.ground_mm = 40;
  seen.signs.ground_share = 0.6F;
  seen.signs.floor_share = 0.3F;
  EXPECT_FLOAT_EQ(ground_of(seen.signs), 40);
  EXPECT_EQ(seen.judged().beside, only(Guidance::feet_raised));
  EXPECT_FLOAT_EQ(seen.judged().ground_mm, 40);
  SurroundingsSigns low = seen.signs;
  low.ground_mm = 12;
  EXPECT_EQ(ground_of(low), 0);
  SurroundingsSigns small = seen.signs;
  small.ground_share = 0.28F;
  small.floor_share = 0.1F;
  EXPECT_EQ(ground_of(small), 0) << "shoes";
  SurroundingsSigns floor = seen.signs;
  floor.floor_share = 0.65F;
  EXPECT_EQ(ground_of(floor), 0) << "most of the ground is floor";
  SurroundingsSigns bent = seen.signs;
  bent.floor.bend = 0.44F;
  EXPECT_EQ(ground_of(bent), 0) << "a bowl rises above its own plane";
}

TEST(Plausibility, ACrownWithoutDepthIsToldAndWidensUpwards) {
  Seen seen;
  seen.described.crown_flatness = 0.7F;
  EXPECT_EQ(seen.judged().beside, 0U) << "a flat head under a background that is seen";
  seen.signs.lost_above_share = 0.9F;
  const Plausibility followed = seen.judged();
  EXPECT_EQ(followed.beside, only(Guidance::head_unseen));
  seen.stance.crown_mm = 1800;
  const Plausibility closed = seen.judged();
  EXPECT_EQ(closed.beside, only(Guidance::head_unseen));
  EXPECT_LT(closed.crown_missing_mm, followed.crown_missing_mm) << "the fitted head is whole";

  index::Answer answer;
  for (index::IntervalEstimate& e : answer.measurements) e = {1700, 1690, 1710};
  correct(followed, answer);
  const auto& stature = answer.measurements[measurement_index(Measurement::stature)];
  EXPECT_FLOAT_EQ(stature.value, 1700 + followed.crown_missing_mm);
  EXPECT_FLOAT_EQ(stature.low, 1690);
  EXPECT_GT(stature.high - stature.value, 2 * 10.0F) << "wider upwards";
  EXPECT_EQ(answer.measurements[measurement_index(Measurement::waist_girth)].value, 1700);

  // A crown flatter than any that is seen whole: of half a head's pixels lost.
  for (const auto& [flatness, lost, told] :
       {std::tuple(0.65F, 0.45F, true), {0.65F, 0.35F, false}, {0.58F, 0.45F, false}}) {
    Seen flat;
    flat.described.crown_flatness = flatness;
    flat.signs.lost_above_share = lost;
    EXPECT_EQ(flat.judged().beside, told ? only(Guidance::head_unseen) : 0U) << flatness << ' ' << lost;
    flat.signs.lost_beside_share = 0.9F;
    EXPECT_EQ(flat.judged().beside, 0U) << "nothing is seen beside the head";
  }

  // Without a background lost pixels say nothing: the shape alone, more strictly.
  seen.signs.lost_beside_share = 0.9F;
  seen.described.crown_flatness = 0.58F;
  EXPECT_EQ(seen.judged().beside, 0U);
  seen.described.crown_flatness = 0.7F;
  EXPECT_EQ(seen.judged().beside, only(Guidance::head_unseen));
}

// Toes near the shin, but not of a shin that leans, of trousers over the shoe, or on a plate.
TEST(Plausibility, RaisedHeelsAreToldAndTakenOff) {
  Seen seen;
  seen.signs.feet_known = true;
  seen.signs.toe_reach_mm = 105;
  seen.signs.ankle_ahead_mm = 8;
  EXPECT_EQ(seen.judged().beside, only(Guidance::feet_raised));
  EXPECT_EQ(seen.judged().ground_mm, 0);
  index::Answer answer;
  for (index::IntervalEstimate& e : answer.measurements) e = {1715, 1700, 1730};
  correct(seen.judged(), answer);
  const auto& stature = answer.measurements[measurement_index(Measurement::stature)];
  EXPECT_NEAR(stature.value, 1667, 0.1F);
  for (const float too_tall : {35.0F, 65.0F}) {
    EXPECT_LT(stature.low, 1715 - too_tall);
    EXPECT_GT(stature.high, 1715 - too_tall);
  }
  EXPECT_EQ(answer.measurements[measurement_index(Measurement::waist_girth)].value, 1715);
  const auto told = [&](float reach_mm, float ahead_mm) {
    Seen other = seen;
    other.signs.toe_reach_mm = reach_mm;
    other.signs.ankle_ahead_mm = ahead_mm;
    return other.judged().beside;
  };
  EXPECT_EQ(told(110, -10), 0U) << "a shin that leans back";
  EXPECT_EQ(told(165, 35), 0U) << "a trouser leg over the shoe";
  EXPECT_NE(told(112, 0), 0U);
  EXPECT_EQ(told(118, 0), 0U);
  EXPECT_NE(told(126, 8), 0U);
  EXPECT_NE(told(143, 12), 0U) << "heels of 50 mm";
  EXPECT_EQ(told(152, 15), 0U) << "a trouser leg over the shoe";
  Seen unknown = seen;
  unknown.signs.feet_known = false;
  EXPECT_EQ(unknown.judged().beside, 0U);
  Seen plate = seen;
  plate.signs.ground_mm = 40;
  plate.signs.ground_share = 0.6F;
  plate.signs.floor_share = 0.3F;
  EXPECT_EQ(plate.judged().heels_mm, 0) << "that is what they stand on";
}

// A fitted body whose stature is not that of the crown: both are in the interval.
TEST(Plausibility, AStatureThatIsNotTheOneSeenWidensItsInterval) {
  const Plausibility judged = Seen().judged();  // the crown at 1722
  const auto corrected = [&](float value, bool clothed, const Plausibility& of) {
    index::Answer answer;
    answer.clothed = clothed;
    for (index::IntervalEstimate& e : answer.measurements) e = {value, value - 15, value + 15};
    correct(of, answer);
    return answer.measurements[measurement_index(Measurement::stature)];
  };
  for (const auto& [over, clothed, widened] : {std::tuple(20.0F, false, false),
                                               {29.0F, false, true},
                                               {-5.0F, true, false},
                                               {11.0F, true, false},
                                               {14.0F, true, true},
                                               {-70.0F, true, false},
                                               {-90.0F, true, true},
                                               {-90.0F, false, true}}) {
    const index::IntervalEstimate stature = corrected(1722 + over, clothed, judged);
    EXPECT_EQ(stature.high - stature.low > 31, widened) << over << clothed;
    EXPECT_LE(stature.low, stature.value);
    EXPECT_GE(stature.high, stature.value);
    if (!widened) continue;
    // A body that ends far below the crown is that of a person in a hat, too.
    EXPECT_FLOAT_EQ(stature.value, over > 0 ? 1722 + over / 2 : 1722 + over);
    EXPECT_LE(stature.low, 1722 - 60) << "soles and hair of what is seen";
    EXPECT_GE(stature.high, 1722 + 10);
    EXPECT_LE(stature.low, 1722 + over - 35);
  }
  Plausibility unseen = judged;
  unseen.seen_stature_mm = std::nanf("");
  EXPECT_EQ(corrected(1900, false, unseen).value, 1900);
  Plausibility crown = judged;
  crown.beside = only(Guidance::head_unseen);
  EXPECT_EQ(corrected(1760, false, crown).low, 1745) << "the crown is counted already";
}

TEST(Plausibility, AnOrdinaryAnswerIsNotCorrected) {
  index::Answer answer;
  for (index::IntervalEstimate& e : answer.measurements) e = {1700, 1690, 1710};
  correct(Seen().judged(), answer);
  for (const index::IntervalEstimate& e : answer.measurements) {
    EXPECT_EQ(e.value, 1700);
    EXPECT_EQ(e.low, 1690);
    EXPECT_EQ(e.high, 1710);
  }
}

// Thighs forward and shanks back by the same angle, as of a squat; by trigonometry.
TEST(FittedStance, KneesAreBentByTheAngleBetweenThighAndShank) {
  for (const float degrees : {0.0F, 10.0F, 24.0F, 60.0F, 90.0F}) {
    body::PosedSkeleton bones;
    const float half = degrees / 2 * std::numbers::pi_v<float> / 180;
    for (const body::Segment thigh : {body::Segment::left_upper_leg, body::Segment::right_upper_leg}) {
      const auto upper = static_cast<std::size_t>(thigh), lower = upper + 1;
      bones.head[upper] = {0, 900, 0};
      bones.tail[upper] = {0, 900 - 430 * std::cos(half), 430 * std::sin(half)};
      bones.head[lower] = bones.tail[upper];
      bones.tail[lower] = bones.head[lower] + Vec3f{0, -400 * std::cos(half), -400 * std::sin(half)};
    }
    EXPECT_NEAR(stance_of(bones, {}, {}).knees_deg, degrees, 0.5F);
  }
  const std::array<Vec3f, 2> points = {{{0, -700, 2000}, {0, -500, 2000}}};
  EXPECT_FLOAT_EQ(stance_of({}, points, {true, {0, -1, 0}, 1000}).crown_mm, 1700);
}

}  // namespace
}  // namespace im2fit
