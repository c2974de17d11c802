// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::FramePixels;
using test::Rig;
using test::Shot;
using test::small_settings;
using test::with;

// run() against sources that end, fail, stutter and go silent.
class StorySource final : public hal::Source {
 public:
  explicit StorySource(std::vector<std::string> story) : story_(std::move(story)) {
    info_.uri = "story";
    info_.intrinsics = small_settings().intrinsics;
  }
  const hal::SourceInfo& info() const override { return info_; }
  Status start() override {
    started = true;
    return Ok{};
  }
  Result<hal::FrameInfo> next(DepthImage depth, int) override {
    const std::string word = at_ < story_.size() ? story_[at_++] : "end";
    if (word == "end") return Error{ErrorCode::end_of_stream, "end"};
    if (word == "away") return is_lost = true, Error{ErrorCode::timeout, "away"};
    is_lost = false;
    if (word == "timeout") return Error{ErrorCode::timeout, "timeout"};
    if (word == "corrupt") return Error{ErrorCode::corrupt, "corrupt"};
    if (word == "gone") return Error{ErrorCode::no_device, "unplugged"};
    Shot shot;
    shot.refused = word == "refused";
    if (word == "back") shot.view = ViewSide::back;
    copy_in(FramePixels(shot), depth);
    ++delivered;
    return hal::FrameInfo{.sequence = delivered, .host_ns = static_cast<std::int64_t>(delivered)};
  }
  void stop() override { stopped = true; }
  hal::SourceStats stats() const override { return {}; }
  bool lost() const override { return is_lost; }
  bool is_lost = false;
  bool started = false;
  bool stopped = false;
  std::uint64_t delivered = 0;

 private:
  static void copy_in(const FramePixels& frame, DepthImage depth) {
    std::memcpy(depth.pixels, frame.pixels.data(), frame.pixels.size() * 2);
  }
  std::vector<std::string> story_;
  std::size_t at_ = 0;
  hal::SourceInfo info_;
};

TEST(Run, PullsToTheEndAndFinishes) {
  Rig rig(with(false));
  StorySource source({"frame", "corrupt", "timeout", "frame", "frame", "frame"});
  EXPECT_TRUE(run(*rig.engine, source, false));
  EXPECT_TRUE(source.stopped);
  EXPECT_EQ(rig.engine->result().frames_seen, 4U);
  EXPECT_TRUE(rig.engine->result().measured);
}

TEST(Run, StopsWhenMeasured) {
  Rig rig(with(true));
  StorySource source(std::vector<std::string>(50, "frame"));
  EXPECT_TRUE(run(*rig.engine, source, true));
  EXPECT_EQ(source.delivered, 10U);
  EXPECT_TRUE(source.stopped);
}

// On two threads, too: no frame is read that the measurement does not need, though many could wait in the pipeline.
TEST(Run, ReadsNoFrameBeyondTheMeasurement) {
  for (const Turn turn : {Turn::none, Turn::back}) {
    EngineSettings settings = with(false);
    settings.turn = turn;
    for (int round = 0; round < 20; ++round) {
      Rig rig(settings);
      rig.control.turns = turn == Turn::back;
      rig.control.sense_delay_us = round % 2 == 0 ? 200 : 0;
      rig.control.fit_delay_us = round % 2 == 0 ? 0 : 200;
      // Refused frames are replaced by as many more.
      std::vector<std::string> story(3, "frame");
      story.insert(story.end(), {"refused", "refused"});
      story.insert(story.end(), 7, "frame");
      story.insert(story.end(), turn == Turn::back ? 10 : 0, "back");
      const std::size_t needed = story.size();
      story.insert(story.end(), 50, "frame");
      StorySource source(story);
      EXPECT_TRUE(run(*rig.engine, source, true));
      EXPECT_TRUE(rig.engine->result().measured);
      EXPECT_EQ(source.delivered, needed);
      EXPECT_EQ(static_cast<std::size_t>(rig.control.sense_calls), needed);
    }
  }
}

TEST(Run, ReportsALostCameraAfterMeasuringWhatCameBefore) {
  Rig rig(with(false));
  StorySource source({"frame", "frame", "frame", "gone", "frame"});
  const Status status = run(*rig.engine, source, false);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::no_device);
  EXPECT_TRUE(rig.engine->result().measured);
}

TEST(Run, GivesUpOnACameraThatGivesNoFrames) {
  Rig rig(with(false));
  StorySource source(std::vector<std::string>(100, "timeout"));
  const Status status = run(*rig.engine, source, false);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::timeout);
  EXPECT_THAT(status.error().message, testing::HasSubstr("story"));
}

TEST(Run, WaitsForACameraThatIsAway) {
  Rig rig(with(false));
  std::vector<std::string> story(100, "away");
  story.insert(story.end(), 10, "frame");
  StorySource source(story);
  EXPECT_TRUE(run(*rig.engine, source, true));
  EXPECT_EQ(source.delivered, 10U);
}

}  // namespace
}  // namespace im2fit
