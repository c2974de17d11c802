// SPDX-License-Identifier: Apache-2.0
#include "train/population/step_round.h"

#include <algorithm>
#include <cmath>

#include "body_fixture.h"
#include "train/population/poses.h"

namespace im2fit::lab {
namespace {

constexpr int kFirst = 45;
StepRoundMotion motion_of(std::uint64_t seed, float degrees = 360) {
  return StepRoundMotion({kFirst, 8, degrees}, seed);
}

TEST(StepRound, TurnsOnceWithoutTurningBack) {
  bool left = false, right = false;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const StepRoundMotion motion = motion_of(seed);
    const float end = motion.yaw_deg(kFirst + 8 * 30);
    EXPECT_NEAR(std::fabs(end), 360, 0.01);
    (end > 0 ? left : right) = true;
    for (std::uint64_t f = 0; f < kFirst; ++f) ASSERT_EQ(motion.yaw_deg(f), 0);
    const float side = end > 0 ? 1.0F : -1.0F;
    float before = 0, fastest = 0;
    for (std::uint64_t f = kFirst; f <= kFirst + 8 * 30 + 30; ++f) {
      const float yaw = side * motion.yaw_deg(f);
      ASSERT_GE(yaw, before - 1e-3F);
      fastest = std::max(fastest, yaw - before);
      before = yaw;
    }
    EXPECT_GT(fastest, 1.5F * 360 / (8 * 30));  // steps, not a turntable
    EXPECT_LT(fastest, 15);
  }
  EXPECT_TRUE(left && right);
}

TEST(StepRound, StaysOnThePlaceAndBreathes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const StepRoundMotion motion = motion_of(seed);
    float most = 0;
    for (std::uint64_t f = 0; f < 400; ++f) {
      const Vec3f shift = motion.shift_mm(f);
      EXPECT_EQ(shift.y, 0);
      ASSERT_LT(std::hypot(shift.x, shift.z), 45);
      ASSERT_LE(std::fabs(motion.breath_mm(f)), 3);
      most = std::max(most, std::fabs(motion.breath_mm(f)));
    }
    EXPECT_GT(most, 2.5F);
  }
}

TEST(StepRound, ZeroSecondsNeverTurn) {
  const StepRoundMotion motion({kFirst, 0, 360}, 3);
  for (const std::uint64_t f : {0U, 45U, 300U}) EXPECT_EQ(motion.yaw_deg(f), 0);
}

class SteppingPose : public WithBody {};

TEST_F(SteppingPose, FeetAreLiftedAndArmsStayOff) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model().vertex_count()));
  model().morph({}, rest);
  const body::Skeleton skeleton = body::rest_skeleton(model(), rest);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    const body::Pose standing = draw_pose(skeleton, StandingPose::arms_out, rng);
    const StepRoundMotion motion = motion_of(seed);
    float lifted_left = 0, lifted_right = 0;
    for (std::uint64_t f = 0; f < kFirst + 8 * 30; f += 2) {
      const body::PosedSkeleton posed = body::pose_skeleton(skeleton, motion.pose(standing, f));
      const auto head = [&](body::Segment s) { return posed.head[static_cast<std::size_t>(s)]; };
      const float left = head(body::Segment::left_foot).y, right = head(body::Segment::right_foot).y;
      lifted_left = std::max(lifted_left, left - right);
      lifted_right = std::max(lifted_right, right - left);
      const Vec3f arm = normalized(head(body::Segment::left_lower_arm) - head(body::Segment::left_upper_arm));
      const float off_deg = std::acos(-arm.y) * 57.29578F;
      ASSERT_GT(off_deg, 20);
      ASSERT_LT(off_deg, 55);
    }
    EXPECT_GT(lifted_left, 5);
    EXPECT_GT(lifted_right, 5);
  }
}

}  // namespace
}  // namespace im2fit::lab
