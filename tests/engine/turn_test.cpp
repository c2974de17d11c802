// SPDX-License-Identifier: Apache-2.0
// The pipeline with a person who turns round on request, on one thread and on two.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::Rig;
using test::Shot;
using test::with;

constexpr GuidanceSet kNear = static_cast<GuidanceSet>(Guidance::too_near);

class TurnThreading : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Threads, TurnThreading, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "one" : "two"; });

EngineSettings turning(bool single) {
  EngineSettings settings = with(single);
  settings.turn = Turn::back;
  return settings;
}
constexpr GuidanceSet kNotFrontal = static_cast<GuidanceSet>(Guidance::not_frontal);
constexpr std::size_t kTurnRoundBit = 13;
constexpr float kFront = 2000.0F * 55 + 2550;  // of ten frames of 2000 mm, and of the back's hundredth
constexpr float kBoth = kFront + (3000.0F * 55 + 2550) / 100;

TEST_P(TurnThreading, FrontThenBackIsMeasuredWithBoth) {
  EngineSettings settings = turning(GetParam());
  std::vector<SessionState> states;
  std::vector<EngineResult> seen;
  settings.watch = [&](const FrameSeen& frame) {
    seen.push_back(frame.result);
    if (states.empty() || states.back() != frame.result.state) states.push_back(frame.result.state);
  };
  Rig rig(settings);
  rig.push({.guidance = kNear});
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  for (int i = 0; i < 4; ++i) rig.push({.value = 2500});  // has not understood yet
  for (int i = 0; i < 3; ++i) rig.push({.guidance = kNotFrontal, .value = 2500, .view = ViewSide::side});
  for (int i = 0; i < 25; ++i) rig.push({.value = 3000, .view = ViewSide::back});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_THAT(states, testing::ElementsAre(SessionState::user_found, SessionState::tracking, SessionState::turning,
                                           SessionState::measured));
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.views, AnswerViews::front_and_back);
  EXPECT_EQ(r.frames_seen, 1U + 10 + 4 + 3 + 10);
  EXPECT_EQ(r.frames_used, 20U);
  EXPECT_EQ(r.frames_back, 10U);
  EXPECT_EQ(r.guidance, 0U);
  EXPECT_EQ(r.guidance_frames[kTurnRoundBit], 1U + 4 + 3) << "from the last frame of the front on";
  EXPECT_EQ(r.answer.measurements[0].value, kBoth);
  EXPECT_EQ(r.measured_joints[Joint::HE].z, 2000.0F) << "the front's";
  EXPECT_EQ(rig.control.measure_calls, 2);

  ASSERT_EQ(seen.size(), 28U);
  EXPECT_FALSE(seen[9].front_measured);
  EXPECT_EQ(seen[9].views, AnswerViews::none);
  for (std::size_t i = 10; i < 27; ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(seen[i].state, SessionState::turning);
    EXPECT_TRUE(seen[i].front_measured);
    EXPECT_FALSE(seen[i].measured);
    EXPECT_EQ(seen[i].views, AnswerViews::front);
    EXPECT_EQ(seen[i].answer.measurements[0].value, kFront) << "preliminary";
    EXPECT_EQ(has(seen[i].guidance, Guidance::turn_round), i < 18);
    EXPECT_EQ(seen[i].frames_used, 10U + (i < 18 ? 0 : i - 17));
  }
}

TEST_P(TurnThreading, WhoDoesNotTurnOrLeavesIsMeasuredFromTheFront) {
  struct Case {
    const char* name;
    Shot shot;
    int frames;          // shown
    std::uint64_t seen;  // until MEASURED, after the front
  };
  const Case cases[] = {
      {"leaves", {.found = false}, 60, kAbsentPeriodsMax + 1},
      {"another takes the place", {.value = 3000, .user = 9, .view = ViewSide::back}, 60, kAbsentPeriodsMax + 1},
      {"does not turn", {.value = 3000}, 500, 451},
      {"never stands right", {.guidance = kNear, .value = 3000, .view = ViewSide::back}, 500, 451},
      {"the stream ends", {.value = 3000}, 3, 3},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Rig rig(turning(GetParam()));
    for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
    for (int i = 0; i < c.frames; ++i) rig.push(c.shot);
    rig.engine->finish();
    const EngineResult r = rig.engine->result();
    EXPECT_EQ(r.state, SessionState::measured);
    EXPECT_TRUE(r.measured);
    EXPECT_EQ(r.views, AnswerViews::front);
    EXPECT_EQ(r.answer.measurements[0].value, kFront);
    EXPECT_EQ(r.frames_used, 10U);
    EXPECT_EQ(r.frames_back, 0U);
    EXPECT_EQ(r.frames_seen, 10U + c.seen);
    EXPECT_EQ(r.guidance, 0U);
  }
}

TEST_P(TurnThreading, TheEndOfTheStreamTakesTheBackFromTheFewestFramesOn) {
  for (const int frames : {2, 3, 9}) {
    Rig rig(turning(GetParam()));
    for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
    for (int i = 0; i < frames; ++i) rig.push({.value = 3000, .view = ViewSide::back});
    rig.engine->finish();
    const EngineResult r = rig.engine->result();
    EXPECT_TRUE(r.measured) << frames;
    EXPECT_EQ(r.views, frames >= 3 ? AnswerViews::front_and_back : AnswerViews::front) << frames;
    EXPECT_EQ(r.frames_used, frames >= 3 ? 10U + static_cast<unsigned>(frames) : 10U);
  }
  Rig rig(turning(GetParam()));
  for (int i = 0; i < 5; ++i) rig.push({.value = 2000});
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured) << "the front of a stream that ends before it";
  EXPECT_EQ(rig.engine->result().views, AnswerViews::front);
  EXPECT_EQ(rig.engine->result().frames_used, 5U);
}

TEST_P(TurnThreading, ABackThatCannotBeDescribedIsLeftOut) {
  Rig rig(turning(GetParam()));
  rig.control.back_describable = false;
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  for (int i = 0; i < 10; ++i) rig.push({.value = 3000, .view = ViewSide::back});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.views, AnswerViews::front);
  EXPECT_EQ(r.answer.measurements[0].value, kFront);
  EXPECT_EQ(r.frames_used, 10U);
}

TEST_P(TurnThreading, WhatCannotBeDescribedAnyMoreTakesThePreliminaryAnswerWithIt) {
  Rig rig(turning(GetParam()));
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  for (int i = 0; i < 9; ++i) rig.push({.value = 3000, .view = ViewSide::back});
  rig.engine->select_user(0);  // waits
  rig.control.describable = false;
  rig.push({.value = 3000, .view = ViewSide::back});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.state, SessionState::tracking);
  EXPECT_FALSE(r.measured || r.front_measured);
  EXPECT_EQ(r.views, AnswerViews::none);
  EXPECT_EQ(r.frames_used, 0U);
  EXPECT_TRUE(std::isnan(r.paper[0]));
  EXPECT_EQ(r.guidance, static_cast<GuidanceSet>(Guidance::too_noisy));
}

TEST_P(TurnThreading, AFrontTakenForABackIsNotAccumulated) {
  Rig rig(turning(GetParam()));
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  for (int i = 0; i < 3; ++i) {
    rig.push({.value = 3500, .view = ViewSide::back});
    rig.push({.value = 3500});
  }
  for (int i = 0; i < 10; ++i) rig.push({.value = 3000, .view = ViewSide::back});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().answer.measurements[0].value, kBoth);
  EXPECT_EQ(rig.engine->result().frames_back, 10U);
}

TEST_P(TurnThreading, ATurnInProgressIsForgottenWithThePerson) {
  for (const bool reset : {true, false}) {
    Rig rig(turning(GetParam()));
    for (int i = 0; i < 10; ++i) rig.push({.value = 3500});
    for (int i = 0; i < 5; ++i) rig.push({.value = 3500, .view = ViewSide::back});
    if (reset)
      rig.engine->reset();
    else
      rig.engine->next_person();
    EngineResult r = rig.engine->result();
    EXPECT_EQ(r.state, SessionState::searching);
    EXPECT_FALSE(r.front_measured);
    EXPECT_EQ(r.views, AnswerViews::none);
    EXPECT_EQ(r.frames_used, 0U);
    for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
    for (int i = 0; i < 10; ++i) rig.push({.value = 3000, .view = ViewSide::back});
    rig.engine->finish();
    r = rig.engine->result();
    EXPECT_EQ(r.views, AnswerViews::front_and_back);
    EXPECT_EQ(r.answer.measurements[0].value, kBoth);
  }
}

TEST_P(TurnThreading, AFrameGapEndsTheTurnWithTheFront) {
  Rig rig(turning(GetParam()));
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  for (int i = 0; i < 9; ++i) rig.push({.value = 3000, .view = ViewSide::back});
  rig.next += 200;
  for (int i = 0; i < 9; ++i) rig.push({.value = 3500, .view = ViewSide::back});
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
  EXPECT_EQ(rig.engine->result().views, AnswerViews::front);
  EXPECT_EQ(rig.engine->result().frames_used, 10U);
}

// Of a rig whose person stood for the front and then turned by a degree a frame.
EngineResult turned_by(int degrees, bool single, bool gap = false) {
  EngineSettings settings = with(single);
  settings.turn = Turn::around;
  Rig rig(settings);
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  for (int i = 1; i <= degrees; ++i) rig.push({.value = static_cast<std::uint16_t>(i), .view = ViewSide::side});
  if (gap) {
    rig.next += 200;
    rig.push({.value = 1, .view = ViewSide::side});
  }
  rig.engine->finish();
  return rig.engine->result();
}

TEST_P(TurnThreading, APersonWhoTurnsAllRoundIsMeasuredSo) {
  constexpr std::size_t kTurnOnBit = 15;
  const EngineResult whole = turned_by(400, GetParam());
  EXPECT_TRUE(whole.measured);
  EXPECT_EQ(whole.views, AnswerViews::around);
  EXPECT_EQ(whole.guidance, 0U);
  EXPECT_EQ(whole.guidance_frames[kTurnRoundBit], 0U) << "from the first frame of the turn on";
  EXPECT_GT(whole.guidance_frames[kTurnOnBit], 300U);
  EXPECT_GE(whole.turned_deg, 330);
  EXPECT_LT(whole.turned_deg, 340) << "it ends by itself";
  EXPECT_EQ(whole.frames_used, 10U + whole.frames_back);
  EXPECT_EQ(whole.frames_back, 110U) << "each third frame";
}

TEST_P(TurnThreading, ATurnCountsFromWhereItIsEnoughOn) {
  for (const bool gap : {false, true}) {
    SCOPED_TRACE(gap);
    const EngineResult enough = turned_by(200, GetParam(), gap);
    EXPECT_EQ(enough.views, AnswerViews::around);
    EXPECT_GT(enough.frames_back, 60U);
    const EngineResult less = turned_by(100, GetParam(), gap);
    EXPECT_TRUE(less.measured);
    EXPECT_EQ(less.views, AnswerViews::front);
    EXPECT_EQ(less.frames_used, 10U);
    EXPECT_EQ(less.frames_back, 0U);
    EXPECT_EQ(less.turned_deg, 99);
  }
}

hal::CameraPose camera_at(float x_mm) {
  hal::CameraPose pose;
  pose.position_mm = {x_mm, 0, 0};
  return pose;
}

// Of a camera that is carried round: the front has the place of the frames that were accumulated, and each picture of
// the turn its own.
TEST_P(TurnThreading, ACameraThatIsCarriedRoundTellsItsPlaces) {
  EngineSettings settings = with(GetParam());
  settings.turn = Turn::walk;
  Rig rig(settings);
  for (int i = 0; i < 9; ++i) rig.push({.value = 2000}, camera_at(10));
  rig.push({.refused = true, .value = 2000}, camera_at(300));
  rig.engine->wait_idle(-1);
  EXPECT_EQ(rig.control.front_x, 10) << "that of a refused frame is not the front's";
  rig.push({.value = 2000}, camera_at(310));
  rig.engine->wait_idle(-1);
  EXPECT_EQ(rig.engine->result().state, SessionState::turning);
  EXPECT_EQ(rig.engine->result().guidance, static_cast<GuidanceSet>(Guidance::walk_round));
  for (int i = 1; i <= 160; ++i)
    rig.push({.value = static_cast<std::uint16_t>(i), .view = ViewSide::side},
             camera_at(310 + 40 * static_cast<float>(i)));
  rig.engine->wait_idle(-1);
  EXPECT_GE(rig.control.follow_x, 310 + 40 * 157);
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().views, AnswerViews::around);
}

// Else a frame would be changed to a view of before, of which the camera has forgotten the way.
TEST_P(TurnThreading, AfterAGapAnotherPersonOrALostPlaceTheViewBeginsAnew) {
  enum class What { nothing, gap, next_person, lost, reset };
  for (const What what : {What::nothing, What::gap, What::next_person, What::lost, What::reset}) {
    EngineSettings settings = with(GetParam());
    settings.frames_wanted = 5;
    Rig rig(settings);
    for (int i = 0; i < 3; ++i) rig.push({.value = 2000}, camera_at(10));
    if (what == What::gap) rig.next += 200;
    if (what == What::next_person) rig.engine->next_person();
    if (what == What::lost) rig.push({.value = 2000});
    if (what == What::reset) rig.engine->reset();
    rig.push({.value = 2000}, camera_at(60));
    rig.engine->wait_idle(-1);
    EXPECT_EQ(rig.control.front_x, what == What::nothing ? 10 : 60) << static_cast<int>(what);
  }
}

TEST_P(TurnThreading, WhoCannotBeMeasuredAllRoundIsNotAskedToTurn) {
  EngineSettings settings = with(GetParam());
  settings.turn = Turn::around;
  bool turning = false;
  settings.watch = [&](const FrameSeen& frame) { turning = turning || frame.result.state == SessionState::turning; };
  Rig rig(settings);
  rig.control.turns = false;
  for (int i = 0; i < 12; ++i) rig.push({.value = 2000});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_FALSE(r.front_measured);
  EXPECT_EQ(r.frames_seen, 10U);
  EXPECT_EQ(r.views, AnswerViews::front);
  EXPECT_FALSE(turning);
}

TEST_P(TurnThreading, WithoutATurnRequestedABackIsRefusedAsBefore) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 9; ++i) rig.push({.value = 2000});
  for (int i = 0; i < 5; ++i) rig.push({.value = 3000, .view = ViewSide::back});
  rig.push({.value = 2000});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_FALSE(r.front_measured);
  EXPECT_EQ(r.views, AnswerViews::front);
  EXPECT_EQ(r.guidance_frames[6], 5U);
  EXPECT_EQ(r.guidance_frames[kTurnRoundBit], 0U);
  EXPECT_EQ(r.answer.measurements[0].value, kFront);
  EXPECT_EQ(rig.control.measure_calls, 1);
}

}  // namespace
}  // namespace im2fit
