// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <thread>

#include "core/rng.h"
#include "engine/engine.h"
#include "pipeline_rig.h"
#include "tests/devices/process_state.h"
#include "tests/devices/thread_starts.h"

namespace im2fit {
namespace {

using test::FakeStages;
using test::FramePixels;
using test::Shot;
using test::small_settings;

constexpr GuidanceSet kNear = static_cast<GuidanceSet>(Guidance::too_near);
constexpr GuidanceSet kMoving = static_cast<GuidanceSet>(Guidance::moving);

using test::Rig;
using test::with;

// Neither the program nor a thread is left behind: not one, and not the other with the first already running.
TEST(Engine, SaysThatAThreadCannotBeStarted) {
  std::thread([] {}).join();  // the thread sanitizer keeps one of its own from the first on
  const int threads = devices::threads();
  FakeStages::Control control;
  for (const int started : {0, 1}) {
    fail_thread_start_after(started);
    const auto engine = create_engine(small_settings(), std::make_unique<FakeStages>(control));
    ASSERT_FALSE(engine) << started;
    EXPECT_EQ(engine.error().code, ErrorCode::io);
    EXPECT_NE(engine.error().message.find("single thread"), std::string::npos) << engine.error().message;
    // A joined thread may be seen for a moment more.
    for (int i = 0; i < 200 && devices::threads() > threads; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(devices::threads(), threads) << started;
  }
  EXPECT_TRUE(create_engine(small_settings(), std::make_unique<FakeStages>(control)));
}

class Threading : public testing::TestWithParam<bool> {};
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
  for (int i = 0; i < 3; ++i) rig.push({.guidance = kNear});
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
  EXPECT_EQ(r.guidance_seen, kNear | kMoving | static_cast<GuidanceSet>(Guidance::no_person));
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
  for (std::uint64_t i = 0; i < kCount; ++i) rig.push(Shot{.guidance = kNear});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_GT(r.frames_dropped, 0U);
  EXPECT_EQ(r.frames_seen + r.frames_dropped, kCount);
}

// The camera was away: whoever stands there after it is not taken for who stood there before.
TEST_P(Threading, AFrameGapOfSecondsEndsWhatWasAccumulated) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 9; ++i) rig.push(Shot{.value = 2000});
  rig.next += 62;  // 2.07 s at 30 Hz
  for (int i = 0; i < 9; ++i) rig.push(Shot{.value = 1000});
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
  EXPECT_EQ(rig.engine->result().frames_used, 9U);
  EXPECT_EQ(rig.engine->result().answer.measurements[0].value, 45 * 1000 + 9 * 255) << "of the second alone";
}

TEST_P(Threading, AShortFrameGapEndsNothing) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 9; ++i) rig.push(Shot{});
  rig.next += 58;  // 1.97 s
  rig.push(Shot{});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().frames_used, 10U);
}

TEST_P(Threading, AfterAFrameGapWithoutAPersonWhoWasThereFindsTheSessionLost) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 5; ++i) rig.push(Shot{});
  rig.next += 100;
  rig.push(Shot{.found = false});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().state, SessionState::lost);
  EXPECT_FALSE(rig.engine->result().measured);
}

TEST_P(Threading, FrameGapsAreNoAttempts) {
  Rig rig(with(GetParam()));
  for (int loss = 0; loss < 30; ++loss) {
    for (int i = 0; i < 4; ++i) rig.push(Shot{});
    rig.next += 100;
  }
  for (int i = 0; i < 10; ++i) rig.push(Shot{});
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
}

// A clock that is set: back is a frame's time like any other, forward a gap, however far.
TEST_P(Threading, AClockMayJumpAnywhere) {
  constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  Rig rig(with(GetParam()));
  const FramePixels frame(Shot{});
  std::uint64_t sequence = 0;
  const auto push_from = [&](std::int64_t host_ns, int frames) {
    for (int i = 0; i < frames; ++i) {
      hal::FrameInfo info;
      info.sequence = sequence++;
      info.host_ns = host_ns + i * 1000;
      EXPECT_TRUE(rig.engine->push(frame.view(), info));
    }
    EXPECT_TRUE(rig.engine->wait_idle(-1));
    return rig.engine->result().frames_used;
  };
  EXPECT_EQ(push_from(kDay_ns, 4), 4U);
  EXPECT_EQ(push_from(1, 3), 7U) << "a day back";
  EXPECT_EQ(push_from(kDay_ns, 2), 2U) << "a day forward";
  EXPECT_EQ(push_from(kFirst, 3), 5U) << "as far back as there is";
  EXPECT_EQ(push_from(kLast - 10'000, 4), 4U) << "as far forward as there is";
  EXPECT_EQ(push_from(kFirst, 6), 10U);
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
  EXPECT_EQ(rig.engine->result().time_reversals, 3U);
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
  for (int i = 9; i < 20; ++i) rig.push({.guidance = kNear, .shift_mm = 5 * i});
  for (int i = 0; i < 40; ++i) rig.push({.value = 3000, .shift_mm = 100});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_TRUE(has(r.guidance_seen, Guidance::moving));
  EXPECT_EQ(r.answer.measurements[0].value, 3000.0F * 55 + 2550) << "only what came after it";
}

TEST_P(Threading, DisplayJointsAreSmoothedAndTheOthersAreNot) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 8; ++i) rig.push({.guidance = kNear});
  rig.push({.guidance = kNear, .shift_mm = 100});
  rig.engine->finish();
  EngineResult r = rig.engine->result();
  EXPECT_EQ(r.joints[Joint::LS].x, 280.0F);
  EXPECT_GT(r.display_joints[Joint::LS].x, 200.0F);
  EXPECT_LT(r.display_joints[Joint::LS].x, 275.0F);
  EXPECT_EQ(r.view, ViewSide::front);
  EXPECT_EQ(r.joints_inferred, 0U);

  rig.engine->reset();
  rig.push({.guidance = kNear});
  rig.push({.found = false});
  rig.push({.guidance = kNear, .shift_mm = 100});
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

TEST_P(Threading, OddArrivalsAreCounted) {
  Rig rig(with(GetParam()));
  const FramePixels frame(Shot{.found = false});
  const std::pair<std::uint64_t, std::int64_t> arrivals[] = {{10, 100}, {11, 200}, {15, 150}, {15, 150}, {14, 300}};
  for (const auto& [sequence, ns] : arrivals) {
    hal::FrameInfo info;
    info.sequence = sequence;
    info.host_ns = ns;
    ASSERT_TRUE(rig.engine->push(frame.view(), info));
  }
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.sequence_gaps, 3U);
  EXPECT_EQ(r.sequence_repeats, 2U);
  EXPECT_EQ(r.time_reversals, 2U);
  EXPECT_EQ(r.frames_seen, 5U);
}

TEST_P(Threading, StridesAreHonoured) {
  Rig rig(with(GetParam()));
  std::vector<std::uint16_t> wide(static_cast<std::size_t>(test::kHeight) * 40, 9);
  const FramePixels frame(Shot{.value = 1500});
  for (int v = 0; v < test::kHeight; ++v)
    std::memcpy(&wide[static_cast<std::size_t>(v) * 40], frame.view().row(v), test::kWidth * 2);
  ASSERT_TRUE(rig.engine->push(DepthView(wide.data(), test::kWidth, test::kHeight, 40), {}));
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().joints[Joint::HE].z, 1500.0F);
}

// A random story of a session.
std::vector<Shot> story(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Shot> shots;
  for (int i = 0; i < 120; ++i) {
    Shot shot;
    shot.found = rng.index(10) != 0;
    shot.guidance = rng.index(3) == 0 ? kNear : 0;
    shot.refused = rng.index(3) == 0;
    shot.value = static_cast<std::uint16_t>(1000 + rng.index(3000));
    if (i > 60 && rng.index(5) != 0) shot.view = ViewSide::back;
    shots.push_back(shot);
  }
  return shots;
}

TEST(Pipeline, TwoThreadsGiveTheBitsOfOne) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    EngineResult results[2];
    for (const bool single : {false, true}) {
      EngineSettings settings = with(single);
      settings.frames_wanted = seed % 2 == 0 ? 40 : 15;
      settings.turn = seed % 2 == 0 ? Turn::none : Turn::asked;
      settings.pool_frames = 3 + static_cast<int>(seed % 6);
      Rig rig(settings);
      for (const Shot& shot : story(seed)) rig.push(shot);
      rig.engine->finish();
      results[single ? 1 : 0] = rig.engine->result();
    }
    EXPECT_EQ(results[0].frames_seen, results[1].frames_seen);
    EXPECT_EQ(results[0].frames_used, results[1].frames_used);
    EXPECT_EQ(results[0].guidance_frames, results[1].guidance_frames);
    EXPECT_EQ(results[0].state, results[1].state);
    EXPECT_EQ(results[0].views, results[1].views);
    EXPECT_EQ(results[0].frames_back, results[1].frames_back);
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      EXPECT_EQ(results[0].answer.measurements[i].value, results[1].answer.measurements[i].value);
    for (std::size_t i = 0; i < kJointCount; ++i)
      EXPECT_EQ(results[0].joints.position_mm[i].x, results[1].joints.position_mm[i].x);
  }
}

TEST(Pipeline, ReplayNeverDropsHoweverSlowTheStagesAre) {
  EngineSettings settings = with(false);
  settings.pool_frames = 3;
  settings.frames_wanted = 200;
  Rig rig(settings);
  rig.control.sense_delay_us = 300;
  rig.control.fit_delay_us = 200;
  for (int i = 0; i < 100; ++i) rig.push({});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().frames_seen, 100U);
  EXPECT_EQ(rig.engine->result().frames_dropped, 0U);
  EXPECT_EQ(rig.engine->result().frames_used, 100U);
}

TEST(Pipeline, LiveDropsTheOldestAndCountsIt) {
  EngineSettings settings = with(false);
  settings.live = true;
  settings.frames_wanted = 1000;
  Rig rig(settings);
  rig.control.sense_delay_us = 3000;
  for (std::uint16_t i = 0; i < 200; ++i) rig.push({.value = static_cast<std::uint16_t>(1000 + i)});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.frames_seen + r.frames_dropped, 200U);
  EXPECT_GT(r.frames_dropped, 100U) << "pushed without a pause against 3 ms a frame";
  EXPECT_GE(r.frames_seen, 2U);
  EXPECT_EQ(r.joints[Joint::HE].z, 1199.0F) << "the newest frame survives";
}

TEST(Pipeline, LiveWithASlowFitStageNeverBlocksTheCamera) {
  EngineSettings settings = with(false);
  settings.live = true;
  settings.frames_wanted = 1000;
  settings.pool_frames = 3;
  Rig rig(settings);
  rig.control.fit_delay_us = 2000;
  for (int i = 0; i < 300; ++i) rig.push({});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.frames_seen + r.frames_dropped, 300U);
  EXPECT_GT(r.frames_dropped, 0U);
}

// Every place is behind SENSE, where nothing can be taken back: the frame that comes then is given up, and counted.
TEST(Pipeline, LiveAFrameForWhichNothingCanBeTakenBackIsCounted) {
  EngineSettings settings = with(false);
  settings.live = true;
  settings.frames_wanted = 1000;
  settings.pool_frames = 3;
  Rig rig(settings);
  rig.control.fit_delay_us = 300'000;  // of the first frame alone
  for (int i = 0; i < settings.pool_frames; ++i) {
    rig.push({});
    while (rig.control.sense_calls <= i) std::this_thread::yield();
  }
  for (int i = 0; i < 5; ++i) rig.push({});
  rig.control.fit_delay_us = 0;
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.frames_seen, 3U);
  EXPECT_EQ(r.frames_dropped, 5U);
}

TEST(Pipeline, ClosesFromAnyStateWithFramesInThePipeline) {
  for (int frames = 0; frames < 12; ++frames) {
    Rig rig(with(false));
    rig.control.sense_delay_us = 500;
    for (int i = 0; i < frames; ++i) rig.push({});
    if (frames % 3 == 1) rig.engine->finish();
    if (frames % 3 == 2) rig.engine->reset();
    rig.engine.reset();
  }
}

TEST(Pipeline, ResultsMayBeReadFromOtherThreadsMeanwhile) {
  EngineSettings settings = with(false);
  settings.frames_wanted = 1000;
  Rig rig(settings);
  std::atomic<bool> stop{false};
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; ++i)
    readers.emplace_back([&] {
      std::uint64_t last = 0;
      while (!stop) {
        const EngineResult r = rig.engine->result();
        EXPECT_GE(r.frames_seen, last);
        EXPECT_LE(r.frames_used, r.frames_seen);
        last = r.frames_seen;
      }
    });
  for (int i = 0; i < 500; ++i) rig.push({});
  rig.engine->finish();
  stop = true;
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(rig.engine->result().frames_seen, 500U);
}

TEST(Pipeline, RefusesAbsurdSettingsAndFrames) {
  struct Case {
    const char* word;
    void (*spoil)(EngineSettings&);
  };
  const Case cases[] = {
      {"width", [](EngineSettings& s) { s.width = 0; }},
      {"height", [](EngineSettings& s) { s.height = 5000; }},
      {"frames_wanted", [](EngineSettings& s) { s.frames_wanted = 0; }},
      {"frames_min", [](EngineSettings& s) { s.frames_min = s.frames_wanted + 1; }},
      {"pool_frames", [](EngineSettings& s) { s.pool_frames = 2; }},
      {"intrinsics", [](EngineSettings& s) { s.intrinsics.fx = 0; }},
      {"intrinsics", [](EngineSettings& s) { s.intrinsics.fy = std::numeric_limits<float>::quiet_NaN(); }},
      {"intrinsics are for 8x12", [](EngineSettings& s) { s.intrinsics.width = 8; }},
  };
  for (const Case& c : cases) {
    EngineSettings settings = small_settings();
    c.spoil(settings);
    FakeStages::Control control;
    auto engine = create_engine(settings, std::make_unique<FakeStages>(control));
    ASSERT_FALSE(engine) << c.word;
    EXPECT_THAT(engine.error().message, testing::HasSubstr(c.word));
  }
  Rig rig(with(false));
  const std::vector<std::uint16_t> small(9, 0);
  const Status status = rig.engine->push(DepthView(small.data(), 3, 3), {});
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, testing::AllOf(testing::HasSubstr("3x3"), testing::HasSubstr("16x12")));
  EXPECT_FALSE(rig.engine->push({}, {}));
}

}  // namespace
}  // namespace im2fit
