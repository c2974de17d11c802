// SPDX-License-Identifier: Apache-2.0
// What the session makes of a measurement that is refused, and of one that has codes beside it.
#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::Rig;
using test::with;

class Refused : public test::Threading {};
INSTANTIATE_TEST_SUITE_P(Threads, Refused, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "One" : "Two"; });

constexpr auto kBent = static_cast<GuidanceSet>(Guidance::floor_bent);
constexpr auto kNotUpright = static_cast<GuidanceSet>(Guidance::not_upright);

TEST_P(Refused, ARefusedPersonHasNoAnswerAndTheCode) {
  Rig rig(with(GetParam()));
  rig.control.refused = kBent;
  for (int i = 0; i < 12; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_FALSE(r.measured);
  EXPECT_EQ(r.state, SessionState::tracking);
  EXPECT_EQ(r.views, AnswerViews::none);
  EXPECT_EQ(r.answer.measurements[0].value, 0);
  EXPECT_EQ(r.plausibility.refused, kBent);
  EXPECT_EQ(r.guidance, kBent) << "said of the frames after it, too";
  EXPECT_EQ(rig.control.measure_calls, 1);
}

TEST_P(Refused, ARefusedPersonWhoStandsCorrectlyIsMeasured) {
  Rig rig(with(GetParam()));
  rig.control.refused = kNotUpright;
  for (int i = 0; i < 10; ++i) rig.push({});
  rig.engine->select_user(0);  // waits
  rig.control.refused = 0;
  for (int i = 0; i < 10; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.guidance, 0U);
  EXPECT_EQ(r.plausibility.refused, 0U);
  EXPECT_TRUE(has(r.guidance_seen, Guidance::not_upright));
}

TEST_P(Refused, OfTheNextPersonNothingIsRefusedYet) {
  Rig rig(with(GetParam()));
  rig.control.refused = kNotUpright;
  for (int i = 0; i < 11; ++i) rig.push({});
  for (int i = 0; i < 40; ++i) rig.push({.found = false});
  rig.push({.user = 2});
  rig.push({.user = 2});
  rig.engine->select_user(0);
  const EngineResult r = rig.engine->result();
  EXPECT_FALSE(has(r.guidance, Guidance::not_upright));
  EXPECT_EQ(r.plausibility.refused, 0U);
}

TEST_P(Refused, ARefusedFrontIsNotTurned) {
  EngineSettings settings = with(GetParam());
  settings.turn = Turn::back;
  Rig rig(settings);
  rig.control.refused = kBent;
  for (int i = 0; i < 12; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.state, SessionState::tracking);
  EXPECT_FALSE(r.front_measured);
}

TEST_P(Refused, CodesBesideAnAnswerStandWithIt) {
  Rig rig(with(GetParam()));
  rig.control.beside = static_cast<GuidanceSet>(Guidance::feet_raised);
  for (int i = 0; i < 10; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.guidance, static_cast<GuidanceSet>(Guidance::feet_raised));
  EXPECT_GT(r.answer.measurements[0].value, 0);
}

}  // namespace
}  // namespace im2fit
