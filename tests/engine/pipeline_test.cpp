// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
using test::kTooNear;
using test::Rig;
using test::Shot;
using test::small_settings;
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

// A random story of a session.
std::vector<Shot> story(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Shot> shots;
  for (int i = 0; i < 120; ++i) {
    Shot shot;
    shot.found = rng.index(10) != 0;
    shot.guidance = rng.index(3) == 0 ? kTooNear : 0;
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
      settings.turn = seed % 2 == 0 ? Turn::none : Turn::back;
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
