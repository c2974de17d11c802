// SPDX-License-Identifier: Apache-2.0
// Frames whose joints are left to FIT: found in the frames' order, by one thread at a time, whoever is faster.
#include <gtest/gtest.h>

#include "tests/engine/fake_stages.h"

namespace im2fit {
namespace {

using test::FakeStages;

// What finishing a frame finds depends on all frames before, as a tracker's does.
class HalvedStages final : public FakeStages {
 public:
  struct Log {
    std::atomic<int> inside{0}, together{0}, by_sense{0}, by_fit{0};
    std::atomic<int> finish_delay_us{0};
  };
  HalvedStages(Control& control, Log& log) : FakeStages(control), log_(log) {}

  Detection sense(DepthView depth, const Intrinsics& k, MaskImage mask, float seconds) override {
    Detection detection = FakeStages::sense(depth, k, mask, seconds);
    detection.person.pixel_count = depth.at(9, 0);
    return detection;
  }
  bool may_finish_later(const Detection& sensed) const override { return sensed.person.pixel_count != 0; }
  void finish(DepthView depth, const Intrinsics&, MaskImage, Detection& detection) override {
    ++log_.by_sense;
    find(depth, detection);
  }
  void finish_later(DepthView depth, const Intrinsics&, MaskView, Detection& detection) override {
    ++log_.by_fit;
    std::this_thread::sleep_for(std::chrono::microseconds(log_.finish_delay_us.load()));
    find(depth, detection);
  }

 private:
  void find(DepthView depth, Detection& detection) {
    if (++log_.inside != 1) ++log_.together;
    state_ = state_ * 31 + depth.at(5, 5);
    detection.joints[Joint::HE].y = static_cast<float>(state_ % 100000);
    --log_.inside;
  }
  Log& log_;
  std::uint32_t state_ = 1;
};

std::vector<float> heads_of(bool single_thread, int finish_delay_us, HalvedStages::Log& log) {
  FakeStages::Control control;
  log.finish_delay_us = finish_delay_us;
  std::vector<float> heads;
  EngineSettings settings = test::small_settings();
  settings.frames_wanted = 200;
  settings.single_thread = single_thread;
  settings.watch = [&](const FrameSeen& seen) { heads.push_back(seen.result.joints[Joint::HE].y); };
  auto engine = create_engine(settings, std::make_unique<HalvedStages>(control, log));
  EXPECT_TRUE(engine);
  for (int i = 0; i < 120; ++i) {
    test::FramePixels frame({.guidance = 1, .value = static_cast<std::uint16_t>(1000 + i)});
    frame.pixels[9] = i % 7 < 4 || i > 80 ? 1 : 0;
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = i < 60 ? (i + 1) * 33333333LL : (i + 40) * 33333333LL;  // with a gap, which resets the stages
    EXPECT_TRUE((*engine)->push(frame.view(), info));
  }
  (*engine)->wait_idle(-1);
  return heads;
}

TEST(Unfinished, FoundInOrderAndTheSameOnOneThreadAndTwo) {
  HalvedStages::Log one;
  const std::vector<float> want = heads_of(true, 0, one);
  ASSERT_EQ(want.size(), 120U);
  EXPECT_GT(one.by_sense, 20);
  EXPECT_GT(one.by_fit, 60);
  for (const int delay_us : {0, 300}) {
    HalvedStages::Log two;
    EXPECT_EQ(heads_of(false, delay_us, two), want) << delay_us;
    EXPECT_EQ(two.together, 0);
    EXPECT_EQ(two.by_fit, one.by_fit);
  }
}

// Of each frame whose it is. Two people take turns; the first one stands right in frame 5.
std::vector<int> users_of(bool single_thread, int finish_delay_us, bool later) {
  FakeStages::Control control;
  HalvedStages::Log log;
  log.finish_delay_us = finish_delay_us;
  std::vector<int> users;
  EngineSettings settings = test::small_settings();
  settings.frames_wanted = 200;
  settings.single_thread = single_thread;
  settings.watch = [&](const FrameSeen& seen) { users.push_back(seen.result.user); };
  auto engine = create_engine(settings, std::make_unique<HalvedStages>(control, log));
  EXPECT_TRUE(engine);
  for (int i = 0; i < 40; ++i) {
    test::FramePixels frame({.guidance = i == 5 ? 0U : 1U, .user = i < 6 || i % 4 == 3 ? 1 : 2});
    frame.pixels[9] = later ? 1 : 0;
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = (i + 1) * 33333333LL;
    EXPECT_TRUE((*engine)->push(frame.view(), info));
  }
  (*engine)->wait_idle(-1);
  return users;
}

// Who stands right is held on to from the next frame on, and a frame later where FIT has to find that out.
TEST(Unfinished, WhoStandsRightIsHeldTheSameOnOneThreadAndTwo) {
  for (const bool later : {false, true}) {
    const std::vector<int> want = users_of(true, 0, later);
    ASSERT_EQ(want.size(), 40U);
    for (std::size_t i = 0; i < want.size(); ++i) {
      const bool let_through = later && i == 6;
      EXPECT_EQ(want[i], i < 6 || i % 4 == 3 ? 1 : let_through ? 2 : 0) << i;
    }
    for (const int delay_us : {0, 300}) EXPECT_EQ(users_of(false, delay_us, later), want) << delay_us;
  }
}

// Also while frames wait to be finished, and while SENSE waits for them.
TEST(Unfinished, EngineEndsAtOnce) {
  for (int repeat = 0; repeat < 20; ++repeat) {
    FakeStages::Control control;
    HalvedStages::Log log;
    log.finish_delay_us = 1000;
    auto engine = create_engine(test::small_settings(), std::make_unique<HalvedStages>(control, log));
    ASSERT_TRUE(engine);
    for (int i = 0; i < 3; ++i) {
      test::FramePixels frame({.guidance = 1});
      frame.pixels[9] = i < 2 ? 1 : 0;
      hal::FrameInfo info;
      info.sequence = static_cast<std::uint64_t>(i);
      EXPECT_TRUE((*engine)->push(frame.view(), info));
    }
  }
}

}  // namespace
}  // namespace im2fit
