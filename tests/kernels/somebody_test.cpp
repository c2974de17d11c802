// SPDX-License-Identifier: Apache-2.0
#include "kernels/observe/somebody.h"

#include <gtest/gtest.h>

namespace im2fit {
namespace {

// A standing adult by hand, mm: x right, y down.
JointSet adult() {
  JointSet joints;
  const auto put = [&](Joint left, Joint right, float x, float y) {
    joints[left] = {x, y, 2500};
    joints[right] = {-x, y, 2500};
  };
  joints[Joint::HE] = {0, -650, 2500};
  joints[Joint::NE] = {0, -500, 2500};
  joints[Joint::TO] = {0, -200, 2500};
  put(Joint::LS, Joint::RS, 170, -480);
  put(Joint::LE, Joint::RE, 230, -210);
  put(Joint::LA, Joint::RA, 260, 70);
  put(Joint::LH, Joint::RH, 90, 20);
  put(Joint::LK, Joint::RK, 100, 410);
  put(Joint::LF, Joint::RF, 110, 825);
  return joints;
}

TEST(SomebodyOdds, GrowWithShapeAndLikeness) {
  EXPECT_GT(somebody_odds(1, 0.7F, adult()), somebody_odds(-1, 0.7F, adult()));
  EXPECT_GT(somebody_odds(1, 0.8F, adult()), somebody_odds(1, 0.7F, adult()));
  EXPECT_GT(somebody_odds(2, 0.9F, adult()), 3);
}

TEST(SomebodyOdds, AnUnevenSkeletonIsLessLikely) {
  JointSet uneven = adult();
  uneven[Joint::LK].y -= 150;  // one thigh shorter, its shank longer
  EXPECT_LT(somebody_odds(1, 0.7F, uneven), somebody_odds(1, 0.7F, adult()) - 2);
}

TEST(SomebodyOdds, ImpossibleLegsAreLessLikely) {
  JointSet dwarf = adult();
  for (const Joint foot : {Joint::LF, Joint::RF}) dwarf[foot].y -= 200;
  EXPECT_LT(somebody_odds(1, 0.7F, dwarf), somebody_odds(1, 0.7F, adult()) - 2);
}

TEST(SomebodyOdds, LeftAndRightAreAlike) {
  JointSet one = adult(), other = adult();
  one[Joint::LF].y += 90;
  other[Joint::RF].y += 90;
  EXPECT_FLOAT_EQ(somebody_odds(1, 0.7F, one), somebody_odds(1, 0.7F, other));
}

// Who is cut off has legs that nobody sees.
TEST(SomebodyOdds, WithoutAShapeLikenessAloneCounts) {
  EXPECT_EQ(somebody_odds(0, 0.7F, adult()), somebody_odds(0, 0.7F, JointSet{}));
  EXPECT_LT(somebody_odds(0, 0.6F, adult()), 0);
  EXPECT_GT(somebody_odds(0, 0.8F, adult()), 2);
}

}  // namespace
}  // namespace im2fit
