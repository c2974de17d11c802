// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "perception/joints/side.h"
#include "tests/perception/joints_board.h"
#include "tests/perception/joints_model_builder.h"

namespace im2fit {
namespace {

using test::Board;

// One tree for the side: every leaf says `score`, unless the board lies under anchor 0 and nothing under anchor 1,
// then leaf 31 (right at each split) says `score_on_board`.
test::ModelRecords side_model(std::int16_t score, std::int16_t score_on_board) {
  test::ModelRecords m = test::constant_model(0, 0, 0, 0);
  m.meta.side_trees = 1;
  // Torso (joint 2), on the board's centre; 400 mm to the right of it, beside the board (reads 600).
  m.side_anchor = {{0, 0, 2}, {400, 0, 2}, {0, 0, 0}, {0, 0, 0}};
  m.side_split.assign(31, {1, 0, 500});
  m.side_leaf.assign(32, score);
  m.side_leaf[31] = score_on_board;
  // A bone that sets the shoulders apart: left is where x is larger.
  m.bone[3 * joint_index(Joint::LS)] = 200;
  m.bone[3 * joint_index(Joint::RS)] = -200;
  return m;
}

TEST(JointSide, ChanceIsTheLogisticFunction) {
  for (int score = -3000; score <= 3000; score += 50) {
    const double exact = 1 / (1 + std::exp(-score / 256.0));
    EXPECT_NEAR(static_cast<double>(joints::chance_of_score(score)), exact, 0.005) << score;
  }
  EXPECT_LT(joints::chance_of_score(-1000000), 1e-4F);
  EXPECT_GT(joints::chance_of_score(1000000), 1 - 1e-4F);
}

TEST(JointSide, ABackExchangesLeftAndRight) {
  const auto front_bytes = side_model(100, -200).bytes();
  const auto back_bytes = side_model(-100, 200).bytes();
  const auto front_model = JointModel::parse(front_bytes, "front");
  const auto back_model = JointModel::parse(back_bytes, "back");
  ASSERT_TRUE(front_model && back_model);
  const Board board;
  JointTracker front(*front_model), back(*back_model);
  const JointSet facing = board.track(front), turned = board.track(back);
  EXPECT_NEAR(facing[Joint::LS].x, 100, 0.01);
  EXPECT_NEAR(facing[Joint::RS].x, -100, 0.01);
  EXPECT_NEAR(turned[Joint::LS].x, -100, 0.01);
  EXPECT_NEAR(turned[Joint::RS].x, 100, 0.01);
  EXPECT_NEAR(front.back_chance(), 1 / (1 + std::exp(200 / 256.0)), 0.005);
  EXPECT_NEAR(back.back_chance(), 1 / (1 + std::exp(-200 / 256.0)), 0.005);
}

TEST(JointSide, OneFrameDoesNotTurnAPerson) {
  const auto bytes = side_model(-100, 200).bytes();
  const auto model = JointModel::parse(bytes, "model");
  ASSERT_TRUE(model);
  Board board;
  JointTracker tracker(*model);
  board.track(tracker);
  EXPECT_GT(tracker.back_chance(), 0.5F);
  // The board reaches under the second anchor: the score of the frame is -100, the mean is still on the other side.
  board.widen(260);
  board.track(tracker, true);
  EXPECT_GT(tracker.back_chance(), 0.5F);
  for (int i = 0; i < 8; ++i) board.track(tracker, true);
  EXPECT_LT(tracker.back_chance(), 0.5F);
  // A cold start forgets.
  const JointSet cold = board.track(tracker);
  EXPECT_NEAR(tracker.back_chance(), 1 / (1 + std::exp(100 / 256.0)), 0.005);
  EXPECT_GT(cold[Joint::LS].x, cold[Joint::RS].x);
}

}  // namespace
}  // namespace im2fit
