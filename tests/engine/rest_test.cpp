// SPDX-License-Identifier: Apache-2.0
// While nothing moves few frames are sensed, whatever happens is seen at once, and people are measured as ever.
#include "engine/rest.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::Rig;
using test::Shot;
using test::with;

constexpr Shot kEmpty{.found = false, .value = 3000};

EngineSettings resting(bool single, bool rest = true) {
  EngineSettings settings = with(single);
  settings.one_after_another = true;
  settings.rest = rest;
  return settings;
}

class RestTest : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Threads, RestTest, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "one" : "two"; });

// A second as ever, then a look every 0.2 s, and every 5 s a frame is sensed.
TEST_P(RestTest, AnEmptyRoomIsSensedEveryFiveSeconds) {
  std::atomic<int> watched{0};
  EngineSettings settings = resting(GetParam());
  settings.watch = [&](const FrameSeen&) { ++watched; };
  Rig rig(settings);
  for (int i = 0; i < 60 * 30; ++i) rig.push(kEmpty);
  EXPECT_TRUE(rig.engine->wait_idle(-1));
  EXPECT_GE(rig.control.sense_calls, 30 + 10);
  EXPECT_LE(rig.control.sense_calls, 30 + 12 + 2);
  EXPECT_GE(watched, 30 + 59 * 5 - 5);
  EXPECT_LE(watched, 30 + 59 * 5 + 15);
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.state, SessionState::searching);
  EXPECT_EQ(r.frames_seen, 1800U);
  EXPECT_EQ(r.guidance_frames[0], 1800U) << "NO_PERSON in every frame";
}

TEST_P(RestTest, WhoComesIsSensedFromTheFirstFrameAndMeasuredAsEver) {
  EngineResult results[2];
  for (const bool rest : {false, true}) {
    Rig rig(resting(GetParam(), rest));
    for (int i = 0; i < 300; ++i) rig.push(kEmpty);
    EXPECT_TRUE(rig.engine->wait_idle(-1));
    const int before = rig.control.sense_calls;
    for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
    rig.engine->finish();
    EXPECT_EQ(rig.control.sense_calls, before + 10) << rest;
    results[rest] = rig.engine->result();
  }
  EXPECT_TRUE(results[1].measured);
  EXPECT_EQ(results[1].answer.measurements[0].value, results[0].answer.measurements[0].value);
  EXPECT_EQ(results[1].frames_seen, results[0].frames_seen);
  EXPECT_EQ(results[1].frames_used, results[0].frames_used);
  EXPECT_EQ(results[1].guidance_frames, results[0].guidance_frames);
}

TEST_P(RestTest, WhoStaysAfterBeingMeasuredIsSensedEveryFiveSeconds) {
  Rig rig(resting(GetParam()));
  for (int i = 0; i < 10; ++i) rig.push({.value = 2000});
  rig.engine->finish();
  ASSERT_TRUE(rig.engine->result().measured);
  rig.engine->next_person();
  const int before = rig.control.sense_calls;
  for (int i = 0; i < 60 * 30; ++i) rig.push({.value = 2000});
  EXPECT_TRUE(rig.engine->wait_idle(-1));
  EXPECT_LE(rig.control.sense_calls - before, 30 + 12 + 10);
  EXPECT_EQ(rig.engine->result().session, 0U) << "still there";
  for (int i = 0; i <= kAbsentPeriodsMax; ++i) rig.push(kEmpty);
  EXPECT_TRUE(rig.engine->wait_idle(-1));
  EXPECT_EQ(rig.engine->result().session, 1U) << "has left";
}

// A person who is only guided is sensed in every frame, however still.
TEST_P(RestTest, WhoIsBeingGuidedIsSensedInEveryFrame) {
  Rig rig(resting(GetParam()));
  for (int i = 0; i < 300; ++i) rig.push({.guidance = static_cast<GuidanceSet>(Guidance::too_near), .value = 2000});
  EXPECT_TRUE(rig.engine->wait_idle(-1));
  EXPECT_EQ(rig.control.sense_calls, 300);
}

// Nor does a room pass for empty where a code asks someone to step away.
TEST_P(RestTest, WhoIsThereButNotFoundIsSensedInEveryFrame) {
  Rig rig(resting(GetParam()));
  for (int i = 0; i < 300; ++i)
    rig.push({.found = false, .guidance = static_cast<GuidanceSet>(Guidance::too_near), .value = 2000});
  EXPECT_TRUE(rig.engine->wait_idle(-1));
  EXPECT_EQ(rig.control.sense_calls, 300);
}

// Which frames are sensed depends on the frames alone.
TEST(RestThreads, OneThreadAndTwoSenseTheSameFrames) {
  std::vector<std::uint64_t> seen[2];
  for (const bool single : {false, true}) {
    EngineSettings settings = resting(single);
    settings.watch = [&](const FrameSeen& frame) { seen[single].push_back(frame.info.sequence); };
    Rig rig(settings);
    rig.control.fit_delay_us = single ? 0 : 50;
    for (int round = 0; round < 3; ++round) {
      for (int i = 0; i < 100; ++i) rig.push(kEmpty);
      for (int i = 0; i < 150; ++i) rig.push({.value = static_cast<std::uint16_t>(1500 + 300 * round)});
    }
    rig.engine->finish();
  }
  EXPECT_LT(seen[0].size(), 600U);
  EXPECT_EQ(seen[0], seen[1]);
}

// Limits are times: half a second of absence is 16 frames at 30 Hz, 6 at 10 Hz and about 31 at 60 Hz.
TEST_P(RestTest, AbsenceIsCountedInTime) {
  struct Camera {
    std::int64_t period_ns;
    int frames_there, frames_lost;
  };
  for (const Camera& camera : {Camera{33333333, 15, 16}, {100000000, 5, 6}, {16666667, 30, 32}}) {
    Rig rig(with(GetParam()));
    rig.period_ns = camera.period_ns;
    for (int i = 0; i < 3; ++i) rig.push(Shot{});
    for (int i = 0; i < camera.frames_there; ++i) rig.push(kEmpty);
    EXPECT_TRUE(rig.engine->wait_idle(-1));
    EXPECT_EQ(rig.engine->result().state, SessionState::tracking) << camera.period_ns;
    for (int i = camera.frames_there; i < camera.frames_lost; ++i) rig.push(kEmpty);
    EXPECT_TRUE(rig.engine->wait_idle(-1));
    EXPECT_EQ(rig.engine->result().state, SessionState::lost) << camera.period_ns;
  }
}

TEST(RestGate, SensesWhateverChangesAndASecondAfterIt) {
  RestGate gate(16, 12);
  std::vector<std::uint16_t> pixels(16 * 12, 3000);
  const DepthView view(pixels.data(), 16, 12);
  const auto step = [&](bool nothing_to_do = true) { return gate.step(view, 1.0F / 30, nothing_to_do); };
  for (int i = 0; i < 30; ++i) ASSERT_EQ(step(), RestStep::sense) << i;
  for (int i = 0; i < 5; ++i) ASSERT_EQ(step(), RestStep::pass) << i;
  EXPECT_EQ(step(), RestStep::repeat);
  EXPECT_EQ(step(false), RestStep::sense) << "there is something to do";
  for (int i = 0; i < 29; ++i) ASSERT_EQ(step(), RestStep::sense) << i;
  EXPECT_EQ(step(), RestStep::pass);
  pixels.assign(pixels.size(), 2000);
  for (int i = 0; i < 30; ++i) ASSERT_EQ(step(), RestStep::sense) << i;
  EXPECT_EQ(step(), RestStep::pass);
  gate.wake();
  EXPECT_EQ(step(), RestStep::sense);
}

}  // namespace
}  // namespace im2fit
