// SPDX-License-Identifier: Apache-2.0
// A camera pulled out and put back, played by a fake in virtual time.
#include <gtest/gtest.h>

#include <deque>

#include "hal/reconnecting_source.h"
#include "support.h"

namespace im2fit::hal {
namespace {

constexpr int kWidth = 8;
constexpr int kHeight = 6;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod_ns = 33 * kMs;

// The camera and the cable: the devices plugged in, over time.
struct World {
  std::int64_t now_ns = 1'000 * kMs;
  bool plugged = true;
  std::string serial = "A1";
  std::string uri = "fake:1";
  Intrinsics camera = camera_of(kWidth, kHeight);
  bool silent = false;
  int io_errors = 0;  // so many reads fail
  bool starts = true;
  int alive = 0;
  int alive_max = 0;
  int openings = 0;
  std::vector<std::int64_t> opening_ns;
  std::int64_t opening_takes_ns = 0;
  std::uint64_t sleeps = 0;
};

class FakeCamera final : public Source {
 public:
  explicit FakeCamera(World& world) : world_(world) {
    world_.alive_max = std::max(world_.alive_max, ++world_.alive);
    info_.uri = world.uri;
    info_.name = "fake camera";
    info_.serial = world.serial;
    info_.intrinsics = world.camera;
    info_.live = true;
  }
  ~FakeCamera() override { --world_.alive; }
  const SourceInfo& info() const override { return info_; }
  Status start() override {
    if (!world_.starts) return Error{ErrorCode::io, "fake camera does not start"};
    began_ns_ = world_.now_ns;
    return Ok{};
  }
  Result<FrameInfo> next(DepthImage, int timeout_ms) override {
    if (!world_.plugged) return Error{ErrorCode::no_device, "fake camera was pulled out"};
    if (world_.io_errors > 0) return --world_.io_errors, Error{ErrorCode::io, "fake camera hiccups"};
    if (world_.silent || timeout_ms * kMs < kPeriod_ns) {
      world_.now_ns += timeout_ms * kMs;
      return Error{ErrorCode::timeout, "nothing"};
    }
    world_.now_ns += kPeriod_ns;
    ++stats_.delivered;
    return FrameInfo{sequence_++, world_.now_ns, (world_.now_ns - began_ns_) / 1000};
  }
  void stop() override {}
  SourceStats stats() const override { return stats_; }

 private:
  World& world_;
  SourceInfo info_;
  SourceStats stats_;
  std::uint64_t sequence_ = 1;
  std::int64_t began_ns_ = 0;
};

class Reconnecting : public testing::Test {
 protected:
  void open() {
    options_.clock = {[this] { return world_.now_ns; },
                      [this](std::int64_t ns) {
                        ASSERT_GT(ns, 0);
                        ++world_.sleeps;
                        world_.now_ns += ns;
                      }};
    options_.changed = [this](const ReconnectStats& stats) { changes_.push_back(stats); };
    auto made = ReconnectingSource::open(
        [this](const SourceInfo*) -> Result<std::unique_ptr<Source>> {
          ++world_.openings;
          world_.opening_ns.push_back(world_.now_ns);
          world_.now_ns += world_.opening_takes_ns;
          if (!world_.plugged) return Error{ErrorCode::no_device, "nothing is plugged in"};
          return std::unique_ptr<Source>(std::make_unique<FakeCamera>(world_));
        },
        options_);
    ASSERT_TRUE(made) << made.error().message;
    source_ = std::move(*made);
    ASSERT_TRUE(source_->start());
  }
  Result<FrameInfo> next(int timeout_ms = 100) { return source_->next(picture_.image(), timeout_ms); }
  // Frames until one is given or the world is `seconds` older.
  Result<FrameInfo> frame_within(int seconds) {
    const std::int64_t end_ns = world_.now_ns + seconds * 1000 * kMs;
    auto frame = next();
    while (!frame && frame.error().code == ErrorCode::timeout && world_.now_ns < end_ns) frame = next();
    return frame;
  }

  World world_;
  ReconnectOptions options_;
  std::vector<ReconnectStats> changes_;
  std::unique_ptr<ReconnectingSource> source_;
  Picture picture_{kWidth, kHeight};
};

TEST_F(Reconnecting, GoesOnWithGrowingNumbersWhenTheSameCameraReturns) {
  open();
  FrameInfo last;
  for (int i = 0; i < 5; ++i) last = *next();
  EXPECT_EQ(last.sequence, 5U);
  world_.plugged = false;
  for (int i = 0; i < 20; ++i) {
    const std::int64_t before_ns = world_.now_ns;
    const auto none = next(100);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, ErrorCode::timeout) << none.error().message;
    EXPECT_EQ(world_.now_ns - before_ns, 100 * kMs) << "the deadline is kept";
    EXPECT_TRUE(source_->lost());
    EXPECT_EQ(source_->info().serial, "A1");
    EXPECT_EQ(world_.alive, 0) << "the lost camera is closed";
  }
  world_.plugged = true;
  const std::int64_t back_ns = world_.now_ns;
  const auto frame = frame_within(10);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_LE(world_.now_ns - back_ns, 3000 * kMs);
  EXPECT_FALSE(source_->lost());
  EXPECT_EQ(frame->sequence, last.sequence + 2) << "one number is missing: the gap shows";
  EXPECT_GT(frame->host_ns, last.host_ns);
  // The device's clock began again; it goes on by the host's.
  EXPECT_EQ(frame->device_us - last.device_us, (frame->host_ns - last.host_ns) / 1000);
  EXPECT_EQ(next()->sequence, last.sequence + 3);
  EXPECT_EQ(source_->stats().delivered, 7U);
  EXPECT_EQ(source_->stats().gaps, 1U);
  const ReconnectStats& about = source_->reconnect_stats();
  EXPECT_EQ(about.lost, 1U);
  EXPECT_EQ(about.recovered, 1U);
  EXPECT_EQ(about.presence, Presence::present);
  ASSERT_EQ(changes_.size(), 2U);
  EXPECT_EQ(changes_[0].presence, Presence::lost);
  EXPECT_EQ(changes_[0].last_error, "fake camera was pulled out");
  EXPECT_EQ(changes_[1].presence, Presence::present);
}

TEST_F(Reconnecting, PausesDoubleUpToTheLargest) {
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  const std::int64_t lost_ns = world_.now_ns;
  world_.opening_ns.clear();
  (void)next(6000);
  std::vector<std::int64_t> at_ms;
  for (const auto ns : world_.opening_ns) at_ms.push_back((ns - lost_ns) / kMs);
  EXPECT_EQ(at_ms, (std::vector<std::int64_t>{100, 300, 700, 1500, 2500, 3500, 4500, 5500}));
  EXPECT_LE(world_.sleeps, 10U) << "it sleeps through its pauses";
  EXPECT_EQ(source_->reconnect_stats().attempts, 8U);
}

TEST_F(Reconnecting, AnotherCameraIsRefusedAndNamed) {
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  (void)next(500);
  world_.plugged = true;
  world_.serial = "B2";
  const auto none = next(5000);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::timeout);
  EXPECT_EQ(world_.alive, 0) << "the foreign camera is closed again";
  EXPECT_GE(source_->reconnect_stats().refused, 3U);
  EXPECT_TRUE(contains(source_->reconnect_stats().last_error, "serial B2")) << source_->reconnect_stats().last_error;
  EXPECT_TRUE(contains(source_->reconnect_stats().last_error, "serial A1"));
  EXPECT_EQ(changes_.size(), 2U) << "lost, and the foreign camera once";
  world_.serial = "A1";
  EXPECT_TRUE(frame_within(3));
}

TEST_F(Reconnecting, WithoutASerialTheUriTellsWhoItIs) {
  world_.serial = "";
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  (void)next(200);
  world_.plugged = true;
  world_.uri = "fake:2";
  EXPECT_FALSE(frame_within(4));
  world_.uri = "fake:1";
  EXPECT_TRUE(frame_within(3));
}

TEST_F(Reconnecting, AnotherModeOrCalibrationIsRefused) {
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  (void)next(200);
  world_.plugged = true;
  const Intrinsics was = world_.camera;
  world_.camera.fx += 0.5F;
  EXPECT_FALSE(frame_within(4));
  EXPECT_TRUE(contains(source_->reconnect_stats().last_error, "other pictures"));
  world_.camera = camera_of(2 * kWidth, kHeight);
  EXPECT_FALSE(frame_within(4));
  world_.camera = was;
  EXPECT_TRUE(frame_within(3));
}

TEST_F(Reconnecting, GivesUpWhenSetToAndStaysSo) {
  options_.give_up_ms = 2000;
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  const std::int64_t lost_ns = world_.now_ns;
  const auto none = next(60'000);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::no_device);
  EXPECT_EQ(world_.now_ns - lost_ns, 2000 * kMs);
  EXPECT_TRUE(contains(none.error().message, "within 2 s")) << none.error().message;
  world_.plugged = true;
  EXPECT_EQ(next().error().code, ErrorCode::no_device);
  EXPECT_FALSE(source_->lost());
  EXPECT_EQ(changes_.back().presence, Presence::given_up);
}

TEST_F(Reconnecting, AFrameGapAndRepeatedErrorsCountAsLossSingleErrorsDoNot) {
  open();
  ASSERT_TRUE(next());
  world_.io_errors = 2;
  ASSERT_TRUE(next(1000));
  EXPECT_EQ(source_->reconnect_stats().lost, 0U);
  world_.io_errors = 3;
  ASSERT_TRUE(frame_within(3));
  EXPECT_EQ(source_->reconnect_stats().lost, 1U);
  world_.silent = true;
  (void)frame_within(2);
  EXPECT_EQ(source_->reconnect_stats().lost, 1U);
  (void)frame_within(2);
  EXPECT_EQ(source_->reconnect_stats().lost, 2U);
  // It opens, but gives nothing: still the same loss.
  (void)frame_within(20);
  EXPECT_EQ(source_->reconnect_stats().lost, 2U);
  EXPECT_EQ(source_->reconnect_stats().recovered, 1U);
  EXPECT_TRUE(source_->lost());
  world_.silent = false;
  EXPECT_TRUE(frame_within(3));
  EXPECT_EQ(source_->reconnect_stats().recovered, 2U);
}

TEST_F(Reconnecting, ACameraThatOpensButDoesNotStartIsTriedAgain) {
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  (void)next(50);
  world_.plugged = true;
  world_.starts = false;
  EXPECT_FALSE(frame_within(3));
  EXPECT_EQ(source_->reconnect_stats().last_error, "fake camera does not start");
  EXPECT_EQ(world_.alive, 0);
  world_.starts = true;
  EXPECT_TRUE(frame_within(3));
}

TEST_F(Reconnecting, ASlowOpeningIsAllThatADeadlineIsLateBy) {
  world_.opening_takes_ns = 400 * kMs;
  open();
  ASSERT_TRUE(next());
  world_.plugged = false;
  for (int i = 0; i < 50; ++i) {
    const std::int64_t before_ns = world_.now_ns;
    EXPECT_FALSE(next(100));
    EXPECT_LE(world_.now_ns - before_ns, 500 * kMs);
  }
}

TEST_F(Reconnecting, AThousandLossesLeaveNothingBehind) {
  open();
  std::uint64_t last_sequence = 0;
  std::int64_t last_ns = 0;
  for (int i = 0; i < 1000; ++i) {
    world_.plugged = false;
    (void)next(250);
    world_.plugged = true;
    const auto frame = frame_within(3);
    ASSERT_TRUE(frame) << i;
    EXPECT_GT(frame->sequence, last_sequence);
    EXPECT_GT(frame->host_ns, last_ns);
    last_sequence = frame->sequence;
    last_ns = frame->host_ns;
    ASSERT_EQ(world_.alive, 1);
  }
  EXPECT_EQ(world_.alive_max, 1) << "the old camera is closed before the new one is opened";
  EXPECT_EQ(source_->reconnect_stats().lost, 1000U);
  EXPECT_EQ(source_->reconnect_stats().recovered, 1000U);
  EXPECT_EQ(source_->stats().delivered, 1000U);
  source_.reset();
  EXPECT_EQ(world_.alive, 0);
}

TEST_F(Reconnecting, StartAfterStopBeginsAnewAlsoWhenLost) {
  open();
  ASSERT_TRUE(next());
  source_->stop();
  EXPECT_EQ(next().error().code, ErrorCode::invalid_argument);
  ASSERT_TRUE(source_->start());
  world_.plugged = false;
  EXPECT_EQ(next(150).error().code, ErrorCode::timeout);
  source_->stop();
  ASSERT_TRUE(source_->start()) << "a lost camera is waited for";
  world_.plugged = true;
  EXPECT_TRUE(frame_within(3));
}

}  // namespace
}  // namespace im2fit::hal
