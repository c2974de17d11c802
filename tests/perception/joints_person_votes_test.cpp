// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "perception/joints/person_votes.h"
#include "perception/joints/tracker.h"
#include "tests/perception/joints_board.h"
#include "tests/perception/joints_model_builder.h"

namespace im2fit {
namespace {

using test::Board;

constexpr std::uint16_t kPixels = 4;
constexpr std::uint16_t kZero = kPixels;  // the first clue
constexpr std::uint16_t kShape = kPixels + 1;
constexpr std::uint16_t kPersonScore = kPixels + 2;
constexpr std::uint16_t kHeights = kPixels + 33;  // by joint

// One tree: leaf 31 (right at each split) says `yes`, all others `no`.
test::ModelRecords person_model(const test::SplitRecord& split, std::int16_t yes, std::int16_t no) {
  test::ModelRecords m = test::constant_model(0, 0, 0, 0);
  // Torso (joint 2), on the board's centre; 400 mm to the right of it, beside the board (reads 600).
  m.person_anchor = {{0, 0, 2}, {400, 0, 2}, {0, 0, 0}, {0, 0, 0}};
  m.person_split.assign(31, split);
  m.person_leaf.assign(32, no);
  m.person_leaf[31] = yes;
  return m;
}

struct Seen {
  explicit Seen(const test::ModelRecords& records)
      : bytes(records.bytes()), model(JointModel::parse(bytes, "by hand")), tracker(*model) {}
  std::vector<std::byte> bytes;
  Result<JointModel> model;
  JointTracker tracker;
};

TEST(PersonVotes, WithoutTreesTheOddsAreZero) {
  test::ModelRecords records = test::constant_model(0, 0, 0, 0);
  records.meta.person_trees = 0;
  records.person_anchor.clear();
  records.person_split.clear();
  records.person_leaf.clear();
  Seen seen(records);
  Board().track(seen.tracker);
  EXPECT_EQ(seen.tracker.person_odds(3), 0.0F);
}

TEST(PersonVotes, AnEmptyMaskIsNoPersonWhoeverWasSeenBefore) {
  Seen seen(person_model({1, 0, 500}, 512, -256));
  Board board;
  board.track(seen.tracker);
  ASSERT_GT(seen.tracker.person_odds(0), 0);
  ASSERT_GT(seen.tracker.person_score(), 0);
  std::fill(board.mask.begin(), board.mask.end(), std::uint8_t{0});
  board.track(seen.tracker);
  EXPECT_EQ(seen.tracker.person_odds(0), -8.0F);
  EXPECT_EQ(seen.tracker.person_score(), 0.0F);
  Board().track(seen.tracker);
  EXPECT_EQ(seen.tracker.person_odds(0), 2.0F);
}

TEST(PersonVotes, DepthsDecide) {
  Seen seen(person_model({1, 0, 500}, 512, -256));
  Board board;
  board.track(seen.tracker);
  EXPECT_EQ(seen.tracker.person_odds(0), 2.0F);
  board.widen(260);  // the board under the second anchor
  board.track(seen.tracker);
  EXPECT_EQ(seen.tracker.person_odds(0), -1.0F);
}

TEST(PersonVotes, TheShapesOddsDecide) {
  Seen seen(person_model({kShape, kZero, 256}, 512, -256));
  Board().track(seen.tracker);
  EXPECT_EQ(seen.tracker.person_odds(1.25F), 2.0F);
  EXPECT_EQ(seen.tracker.person_odds(0.75F), -1.0F);
  EXPECT_EQ(seen.tracker.person_odds(1e9F), 2.0F) << "no overflow";
  EXPECT_EQ(seen.tracker.person_odds(-1e9F), -1.0F);
}

TEST(PersonVotes, PersonScoreDecides) {
  // The builder's table: of runs that agree 0.75 by 0.708, 1.059.
  Seen below(person_model({kPersonScore, kZero, 4300}, 512, -256));
  Seen above(person_model({kPersonScore, kZero, 4400}, 512, -256));
  Board().track(below.tracker);
  Board().track(above.tracker);
  EXPECT_EQ(below.tracker.person_odds(0), 2.0F);
  EXPECT_EQ(above.tracker.person_odds(0), -1.0F);
}

TEST(PersonVotes, HeightsAboveTheFloorDecide) {
  Board board;
  board.person.floor.known = true;
  board.person.floor.up = {0, -1, 0};
  board.person.floor.camera_height_mm = 1234;
  const auto above = [&](std::int16_t limit_mm) {
    Seen seen(person_model({static_cast<std::uint16_t>(kHeights + joint_index(Joint::TO)), kZero, limit_mm}, 512, 0));
    board.track(seen.tracker);
    return seen.tracker.person_odds(0) > 0;
  };
  // The board's centre lies on the optical axis, within a pixel of 7 mm.
  EXPECT_TRUE(above(1225));
  EXPECT_FALSE(above(1243));
  board.person.floor.known = false;
  EXPECT_FALSE(above(0));
  EXPECT_TRUE(above(-1));
}

// Mirrored anchors read from the mirror image the values of the view.
TEST(PersonVotes, AMirrorImageReadsTheSame) {
  test::ModelRecords records = test::constant_model(10, 5, 0, 3);
  records.bone[3 * joint_index(Joint::LA)] = 200;
  Seen seen(records);
  Board board;
  for (int v = 90; v < 150; ++v)
    for (int u = 140; u < 180; ++u)
      board.depth[static_cast<std::size_t>(v * board.width + u)] = static_cast<std::uint16_t>(1900 + 5 * (u - 140));
  board.person.floor = {true, {0.1F, -0.99F, 0.05F}, 1000};
  board.track(seen.tracker);
  std::vector<joints::Anchor> anchors, others;
  for (std::uint8_t j = 0; j < kJointCount; ++j) {
    anchors.push_back({static_cast<std::int16_t>(20 * j - 130), -30, j, j, 0});
    const auto m = static_cast<std::uint8_t>(mirror_of(static_cast<Joint>(j)));
    others.push_back({static_cast<std::int16_t>(130 - 20 * j), -30, m, m, 0});
  }
  joints::VoteValues values{}, mirror_values{};
  joints::Witness witness = {1.5F, seen.tracker.person_score(), board.person.floor};
  joints::read_values(anchors, seen.tracker.view(), seen.tracker.estimate(), witness, values.data());
  joints::View mirror_image;
  joints::mirror(seen.tracker.view(), mirror_image);
  witness.floor.up.x = -witness.floor.up.x;
  joints::read_values(others, mirror_image, joints::mirrored(seen.tracker.estimate()), witness, mirror_values.data());
  int apart = 0;
  for (std::size_t i = 0; i < kJointCount; ++i) apart += values[i] == mirror_values[i] ? 0 : 1;
  EXPECT_LE(apart, 2) << "where an anchor lies between two pixels";
  for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(values[kJointCount + c], mirror_values[kJointCount + c]);
  for (std::size_t group = 0; group < 3; ++group) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const std::size_t first = kJointCount + 3 + group * kJointCount;
      EXPECT_NEAR(values[first + j], mirror_values[first + joint_index(kJointMirror[j])], 1) << group << " " << j;
    }
  }
}

}  // namespace
}  // namespace im2fit
