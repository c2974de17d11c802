// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "engine/engine.h"
#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::FramePixels;
using test::kStillMoving;
using test::kTooNear;
using test::Rig;
using test::Shot;
using test::small_settings;
using test::Threading;
using test::with;

INSTANTIATE_TEST_SUITE_P(Threads, Threading, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "one" : "two"; });

// A damaged index is queried once; then every push fails, until another person is measured.
TEST_P(Threading, ADamagedIndexEndsTheSessionWithItsError) {
  Rig rig(with(GetParam()));
  const auto reported = [&](const Status& status) {
    return !status && status.error().code == ErrorCode::corrupt &&
           status.error().message.find("people.i2f") != std::string::npos;
  };
  const FramePixels frame(Shot{});
  std::uint64_t sequence = 1000;
  const auto push = [&] {
    hal::FrameInfo info;
    info.sequence = ++sequence;
    return rig.engine->push(frame.view(), info);
  };
  rig.control.damaged = true;
  for (int i = 0; i < 25; ++i) (void)push();
  rig.engine->finish();
  EXPECT_TRUE(reported(rig.engine->fault()));
  EXPECT_FALSE(rig.engine->result().measured);
  EXPECT_EQ(rig.control.measure_calls, 1);
  rig.engine->reset();
  EXPECT_TRUE(rig.engine->fault());

  for (int i = 0; i < 4; ++i) EXPECT_TRUE(push());
  rig.engine->finish();  // enough to measure with
  EXPECT_TRUE(reported(rig.engine->fault()));
  EXPECT_EQ(rig.control.measure_calls, 2);
  rig.engine->reset();

  for (int i = 0; i < 10; ++i) EXPECT_TRUE(push());
  Status last = Ok{};
  for (int i = 0; i < 10000 && last; ++i) last = push();
  EXPECT_TRUE(reported(last));

  rig.control.damaged = false;
  rig.engine->next_person();
  EXPECT_TRUE(rig.engine->fault());
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(push());
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->fault());
  EXPECT_TRUE(rig.engine->result().measured);
}

TEST_P(Threading, MeasuresAfterTheWantedFramesAndOnlyOnce) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 4; ++i) rig.push({.found = false});
  for (int i = 0; i < 3; ++i) rig.push({.guidance = kTooNear});
  rig.push({.refused = true});
  double sum = 0;
  for (int i = 1; i <= 10; ++i) {
    rig.push({.value = static_cast<std::uint16_t>(1000 + i)});
    sum += i * (1000.0 + i) + ((1000 + i) % 2 == 0 ? 255 : 0);
  }
  for (int i = 0; i < 25; ++i) rig.push({.value = 3000});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.state, SessionState::measured);
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.frames_seen, 18U) << "frames after the measurement change nothing";
  EXPECT_EQ(r.frames_used, 10U);
  EXPECT_EQ(r.frames_dropped, 0U);
  EXPECT_EQ(r.guidance, 0U);
  EXPECT_EQ(r.guidance_seen, kTooNear | kStillMoving | static_cast<GuidanceSet>(Guidance::no_person));
  EXPECT_EQ(r.guidance_frames[0], 4U);
  EXPECT_EQ(r.guidance_frames[1], 3U);
  EXPECT_EQ(r.guidance_frames[8], 1U);
  EXPECT_EQ(r.answer.measurements[0].value, static_cast<float>(sum));
  EXPECT_EQ(r.answer.nearest, 7U);
  EXPECT_EQ(r.measured_joints[Joint::HE].z, 1010.0F);
  EXPECT_EQ(rig.control.measure_calls, 1);
  EXPECT_EQ(rig.engine->fused_depth_q4().width, 1);
  EXPECT_EQ(rig.engine->fused_mask().width, 1);
}

// Five frames of thirty show the arms apart: none of them is measured, and the result says which arm it is.
TEST_P(Threading, LuckyFramesOfCloseArmsAreNotMeasured) {
  constexpr GuidanceSet kClose = static_cast<GuidanceSet>(Guidance::arms_close);
  constexpr std::size_t kArmsBit = 5;
  Rig rig(with(GetParam()));
  for (int i = 0; i < 30; ++i) {
    if (i % 6 == 3)
      rig.push({});
    else
      rig.push({.guidance = kClose, .arms_close = kLeftArm});
  }
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_FALSE(r.measured);
  EXPECT_EQ(r.guidance, kClose);
  EXPECT_EQ(r.arms_close, kLeftArm);
  EXPECT_EQ(r.arms_close_frames[0], r.guidance_frames[kArmsBit]);
  EXPECT_EQ(r.arms_close_frames[1], 0U);
  EXPECT_LE(r.frames_used, 1U);
}

TEST_P(Threading, TheEndOfTheStreamMeasuresFromTheFewestFramesOn) {
  for (const int frames : {2, 3, 9}) {
    Rig rig(with(GetParam()));
    for (int i = 0; i < frames; ++i) rig.push({});
    for (int i = 0; i < 40; ++i) rig.push({.found = false});  // walks away: LOST, but was there
    EXPECT_TRUE(rig.engine->fused_mask().pixels == nullptr) << "only after finish()";
    rig.engine->finish();
    const EngineResult r = rig.engine->result();
    EXPECT_EQ(r.measured, frames >= 3) << frames;
    EXPECT_EQ(r.state, frames >= 3 ? SessionState::measured : SessionState::lost) << frames;
    EXPECT_EQ(rig.control.measure_calls, frames >= 3 ? 1 : 0);
    EXPECT_EQ(r.frames_seen, static_cast<std::uint64_t>(frames) + 40);
  }
}

TEST_P(Threading, WithoutFramesFinishGivesNoMeasurement) {
  Rig rig(with(GetParam()));
  rig.engine->finish();
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_FALSE(r.measured);
  EXPECT_EQ(r.state, SessionState::searching);
  EXPECT_EQ(rig.engine->fused_depth_q4().pixels, nullptr);
  const Status late = rig.engine->push(FramePixels(Shot{}).view(), {});
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().message, testing::HasSubstr("reset()"));
}

TEST_P(Threading, WhatCannotBeDescribedIsAccumulatedAgainAndSaysTooNoisy) {
  Rig rig(with(GetParam()));
  rig.control.describable = false;
  for (int i = 0; i < 25; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_FALSE(r.measured);
  EXPECT_TRUE(has(r.guidance_seen, Guidance::too_noisy));
  EXPECT_EQ(rig.control.measure_calls, 3) << "after 10, after 20, and the 5 at the end";
}

TEST_P(Threading, ResetForgetsThePersonAndStartsAgain) {
  Rig rig(with(GetParam()));
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 12; ++i) rig.push({.value = 2000});
    if (round != 1) rig.engine->finish();
    rig.engine->reset();
    const EngineResult r = rig.engine->result();
    EXPECT_FALSE(r.measured);
    EXPECT_EQ(r.frames_seen, 0U);
    EXPECT_EQ(r.state, SessionState::searching);
    EXPECT_TRUE(std::isnan(r.paper[0]));
  }
  for (int i = 0; i < 12; ++i) rig.push({.value = 2000});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().answer.measurements[0].value, 2000.0F * 55 + 2550);
  EXPECT_EQ(rig.engine->result().measured_joints[Joint::HE].x, 9.0F) << "the sensor was reset too";
}

TEST_P(Threading, CalibrationAsksForPsiAndThenForRelaxedStanding) {
  EngineSettings settings = with(GetParam());
  settings.calibration_psi = true;
  Rig rig(settings);
  for (int i = 0; i < 3; ++i) rig.push({});
  for (int i = 0; i < 8; ++i) rig.push({.psi = true});
  for (int i = 0; i < 10; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.guidance_frames[12], 3U + 4U) << "three without the pose, four until it held";
  EXPECT_EQ(r.guidance_frames[8], 3U) << "arms still raised";
  EXPECT_EQ(r.frames_seen, 21U);
}

TEST_P(Threading, StaysWithItsUserAndIsLostWithHim) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 4; ++i) rig.push({.user = 2});
  for (int i = 0; i < 3; ++i) rig.push({.user = 9});  // another steps in front
  for (int i = 0; i < 3; ++i) rig.push({.user = 2});
  for (int i = 0; i <= kAbsentPeriodsMax; ++i) rig.push({.user = 9});
  for (int i = 0; i < 10; ++i) rig.push({.value = 3000, .user = 9});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.user, 9);
  EXPECT_EQ(r.guidance_frames[0], 3U + kAbsentPeriodsMax + 1) << "NO_PERSON while only another is there";
  EXPECT_EQ(r.answer.measurements[0].value, 3000.0F * 55 + 2550) << "the first user's frames are forgotten";
}

// A source writes into the pool itself.
TEST_P(Threading, FramesWrittenInPlaceMeasureAsFramesPushed) {
  Rig pushed(with(GetParam())), written(with(GetParam()));
  EXPECT_FALSE(written.engine->commit({})) << "nothing was acquired";
  for (int i = 0; i < 12; ++i) {
    const Shot shot{.value = static_cast<std::uint16_t>(1000 + i)};
    pushed.push(shot);
    const auto place = written.engine->acquire();
    ASSERT_TRUE(place);
    const auto again = written.engine->acquire();
    ASSERT_TRUE(again);
    EXPECT_EQ(again->pixels, place->pixels) << "the same until commit()";
    const FramePixels frame(shot);
    std::memcpy(place->pixels, frame.pixels.data(), frame.pixels.size() * sizeof(std::uint16_t));
    hal::FrameInfo info;
    info.sequence = written.next;
    info.host_ns = static_cast<std::int64_t>(++written.next) * 33333333;
    ASSERT_TRUE(written.engine->commit(info));
  }
  ASSERT_TRUE(written.engine->acquire()) << "a place that is held keeps no one from finishing";
  pushed.engine->finish();
  written.engine->finish();
  EXPECT_FALSE(written.engine->acquire());
  EXPECT_TRUE(written.engine->result().measured);
  EXPECT_EQ(written.engine->result().answer.measurements[0].value,
            pushed.engine->result().answer.measurements[0].value);
  written.engine->reset();
  EXPECT_TRUE(written.engine->acquire());
}

// Live, with every slot taken, a source still has a place to write to; what cannot be kept is counted.
TEST(Engine, ALiveSourceAlwaysHasAPlace) {
  EngineSettings settings = small_settings();
  settings.live = true;
  settings.pool_frames = 3;
  Rig rig(settings);
  rig.control.sense_delay_us = 2000;
  rig.control.fit_delay_us = 2000;
  constexpr std::uint64_t kCount = 200;
  for (std::uint64_t i = 0; i < kCount; ++i) rig.push(Shot{.guidance = kTooNear});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_GT(r.frames_dropped, 0U);
  EXPECT_EQ(r.frames_seen + r.frames_dropped, kCount);
}

TEST_P(Threading, AUserMayBeChosenWhileOthersAreThere) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 5; ++i) rig.push({.user = 1});
  rig.engine->select_user(2);
  EXPECT_EQ(rig.engine->result().frames_used, 0U);
  for (int i = 0; i < 5; ++i) rig.push({.user = 1});
  for (int i = 0; i < 4; ++i) rig.push({.value = 3000, .user = 2});
  rig.engine->select_user(2);  // no change
  for (int i = 0; i < 6; ++i) rig.push({.value = 3000, .user = 2});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.user, 2);
  EXPECT_EQ(r.user_count, 1);
  EXPECT_EQ(r.users[0].id, 2);
  EXPECT_EQ(r.guidance_frames[0], 5U) << "NO_PERSON: not the one chosen";
  EXPECT_EQ(r.answer.measurements[0].value, 3000.0F * 55 + 2550);
}

TEST_P(Threading, AWalkIsNotAccumulated) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 9; ++i) rig.push({.shift_mm = 5 * i});  // 150 mm/s; seen after 16 frames
  for (int i = 9; i < 20; ++i) rig.push({.guidance = kTooNear, .shift_mm = 5 * i});
  for (int i = 0; i < 40; ++i) rig.push({.value = 3000, .shift_mm = 100});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_TRUE(has(r.guidance_seen, Guidance::moving));
  EXPECT_EQ(r.answer.measurements[0].value, 3000.0F * 55 + 2550) << "only what came after it";
}

TEST_P(Threading, DisplayJointsAreSmoothedAndTheOthersAreNot) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 8; ++i) rig.push({.guidance = kTooNear});
  rig.push({.guidance = kTooNear, .shift_mm = 100});
  rig.engine->finish();
  EngineResult r = rig.engine->result();
  EXPECT_EQ(r.joints[Joint::LS].x, 280.0F);
  EXPECT_GT(r.display_joints[Joint::LS].x, 200.0F);
  EXPECT_LT(r.display_joints[Joint::LS].x, 275.0F);
  EXPECT_EQ(r.view, ViewSide::front);
  EXPECT_EQ(r.joints_inferred, 0U);

  rig.engine->reset();
  rig.push({.guidance = kTooNear});
  rig.push({.found = false});
  rig.push({.guidance = kTooNear, .shift_mm = 100});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().display_joints[Joint::LS].x, 280.0F) << "a loss begins anew";
}

TEST_P(Threading, TheWatchSeesEveryFrameInOrder) {
  EngineSettings settings = with(GetParam());
  std::vector<std::uint64_t> sequences;
  std::vector<int> depths;
  settings.watch = [&](const FrameSeen& frame) {
    sequences.push_back(frame.info.sequence);
    depths.push_back(frame.depth.at(5, 5));
    EXPECT_EQ(frame.mask.at(5, 5), 255);
    EXPECT_EQ(frame.result.frames_seen, sequences.size());
    EXPECT_EQ(frame.users.size(), 1U);
  };
  Rig rig(settings);
  for (int i = 0; i < 6; ++i) rig.push({.value = static_cast<std::uint16_t>(1000 + 2 * i)});
  rig.engine->finish();
  EXPECT_THAT(sequences, testing::ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(depths, testing::ElementsAre(1000, 1002, 1004, 1006, 1008, 1010));
}

}  // namespace
}  // namespace im2fit
