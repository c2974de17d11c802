// SPDX-License-Identifier: Apache-2.0
// Poses set by hand; the gate must name what is wrong with each and nothing else.
#include "perception/observe/gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/perception/analytic_figure.h"

namespace im2fit {
namespace {

constexpr float kDistanceMm = 2300;
const FloorPlane kLevelFloor{true, {0, -1, 0}, 970};

JointSet standing() {
  return test::standing_figure(0, kDistanceMm).joints;
}

// Turns the joints about the upright axis through the person.
JointSet turned(double degrees) {
  JointSet joints = standing();
  const auto c = static_cast<float>(std::cos(degrees * 0.017453292519943295));
  const auto s = static_cast<float>(std::sin(degrees * 0.017453292519943295));
  for (Vec3f& p : joints.position_mm) {
    const float z = p.z - kDistanceMm;
    p = {c * p.x + s * z, p.y, kDistanceMm - s * p.x + c * z};
  }
  return joints;
}

// Leans sideways about the feet.
JointSet leaning(double degrees) {
  JointSet joints = standing();
  const auto c = static_cast<float>(std::cos(degrees * 0.017453292519943295));
  const auto s = static_cast<float>(std::sin(degrees * 0.017453292519943295));
  for (Vec3f& p : joints.position_mm) {
    const float y = p.y - 850;
    p = {c * p.x - s * y, 850 + s * p.x + c * y, p.z};
  }
  return joints;
}

TEST(PoseGate, StandingStraightPasses) {
  EXPECT_EQ(pose_gate(standing(), kLevelFloor), 0U);
  EXPECT_EQ(pose_gate(turned(180), kLevelFloor), 0U) << "seen from behind";
  EXPECT_EQ(pose_gate(turned(8), kLevelFloor), 0U) << "no person stands quite square";
}

TEST(PoseGate, TurnedIsNotFrontal) {
  EXPECT_EQ(pose_gate(turned(35), kLevelFloor), static_cast<GuidanceSet>(Guidance::not_frontal));
  EXPECT_EQ(pose_gate(turned(-35), kLevelFloor), static_cast<GuidanceSet>(Guidance::not_frontal));
}

TEST(PoseGate, TheTurnAllowedLiesBetweenStandingSquareAndTurnedAside) {
  for (const int side : {-1, 1})
    for (const int facing : {0, 180}) {
      EXPECT_EQ(pose_gate(turned(facing + side * 16), kLevelFloor), 0U);
      EXPECT_TRUE(has(pose_gate(turned(facing + side * 20), kLevelFloor), Guidance::not_frontal));
    }
}

TEST(ViewSide, FrontBackSideByTheJointsThemselves) {
  for (const int degrees : {-15, 0, 15}) {
    EXPECT_EQ(view_side(turned(degrees), kLevelFloor), ViewSide::front) << degrees;
    EXPECT_EQ(view_side(turned(180 + degrees), kLevelFloor), ViewSide::back) << degrees;
  }
  for (const int degrees : {30, 90, 150, 210, 270, 330})
    EXPECT_EQ(view_side(turned(degrees), kLevelFloor), ViewSide::side) << degrees;
}

TEST(ViewSide, TheTrackersBackProbabilityMayDecide) {
  const JointSet joints = standing();  // left and right as of a person facing the camera
  EXPECT_EQ(view_side(joints, kLevelFloor, 0.1F), ViewSide::front);
  EXPECT_EQ(view_side(joints, kLevelFloor, 0.9F), ViewSide::back);
  EXPECT_EQ(view_side(joints, kLevelFloor, 0.5F), ViewSide::unknown);
  EXPECT_EQ(view_side(turned(60), kLevelFloor, 0.9F), ViewSide::side);
  EXPECT_EQ(view_side(turned(180), kLevelFloor, 0.55F), ViewSide::unknown) << "named as of a back, but hardly";
  EXPECT_EQ(view_side(turned(180), kLevelFloor, 0.7F), ViewSide::back);
}

TEST(ViewSide, JointsThatSpanNoLineLeaveItUnknown) {
  EXPECT_EQ(view_side(JointSet{}, kLevelFloor), ViewSide::unknown);
  JointSet broken = standing();
  broken[Joint::LS].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(view_side(broken, kLevelFloor), ViewSide::unknown);
}

TEST(PoseGate, NeitherFrontNorBackIsNotFrontal) {
  for (const ViewSide view : {ViewSide::front, ViewSide::back})
    EXPECT_EQ(pose_gate(standing(), kLevelFloor, view), 0U);
  for (const ViewSide view : {ViewSide::side, ViewSide::unknown})
    EXPECT_EQ(pose_gate(standing(), kLevelFloor, view), static_cast<GuidanceSet>(Guidance::not_frontal));
}

TEST(PoseGate, IsHeardWhereThePoseCanBeSeen) {
  const GuidanceSet trunk = Guidance::not_upright | Guidance::not_frontal;
  const GuidanceSet all = trunk | static_cast<GuidanceSet>(Guidance::arms_close);
  const auto seen = [](Guidance of_mask, ViewSide view = ViewSide::front) {
    return pose_codes_seen(static_cast<GuidanceSet>(of_mask), view);
  };
  EXPECT_EQ(pose_codes_seen(0, ViewSide::unknown), all);
  EXPECT_EQ(seen(Guidance::several_people), all);
  EXPECT_EQ(seen(Guidance::feet_cut), all & ~static_cast<GuidanceSet>(Guidance::not_upright))
      << "the floor is a guess";
  EXPECT_EQ(seen(Guidance::side_cut), trunk) << "the hand is outside";
  for (const ViewSide view : {ViewSide::front, ViewSide::back, ViewSide::unknown})
    EXPECT_EQ(seen(Guidance::head_cut, view), all & ~static_cast<GuidanceSet>(Guidance::not_frontal))
        << "front and back cannot be distinguished";
  EXPECT_EQ(seen(Guidance::head_cut, ViewSide::side), all);
  for (const Guidance unseen : {Guidance::too_near, Guidance::too_far, Guidance::too_noisy})
    EXPECT_EQ(seen(unseen), 0U);
}

// Bows about the hips, legs upright.
JointSet bowing(double degrees) {
  JointSet joints = standing();
  const auto c = static_cast<float>(std::cos(degrees * 0.017453292519943295));
  const auto s = static_cast<float>(std::sin(degrees * 0.017453292519943295));
  const Vec3f hip = (joints[Joint::LH] + joints[Joint::RH]) * 0.5F;
  for (const Joint j :
       {Joint::HE, Joint::NE, Joint::TO, Joint::LS, Joint::RS, Joint::LE, Joint::RE, Joint::LA, Joint::RA}) {
    const Vec3f d = joints[j] - hip;
    joints[j] = hip + Vec3f{d.x, c * d.y - s * d.z, s * d.y + c * d.z};
  }
  return joints;
}

TEST(PoseGate, BowingIsNotUpright) {
  EXPECT_EQ(pose_gate(bowing(10), kLevelFloor), 0U);
  EXPECT_EQ(pose_gate(bowing(25), kLevelFloor), static_cast<GuidanceSet>(Guidance::not_upright));
  EXPECT_EQ(pose_gate(bowing(-25), kLevelFloor), static_cast<GuidanceSet>(Guidance::not_upright));
}

TEST(PoseGate, LeaningIsNotUpright) {
  EXPECT_TRUE(has(pose_gate(leaning(25), kLevelFloor), Guidance::not_upright));
  EXPECT_FALSE(has(pose_gate(leaning(8), kLevelFloor), Guidance::not_upright));
}

// A picture turned by half a circle, whose --rotate is missing.
TEST(PoseGate, UpsideDownIsNotUpright) {
  EXPECT_TRUE(has(pose_gate(leaning(180), kLevelFloor), Guidance::not_upright));
}

TEST(PoseGate, UprightMeansAgainstTheFloorNotThePicture) {
  // The camera rolls by 25 degrees: picture and floor lean together.
  const double a = 25 * 0.017453292519943295;
  JointSet joints = leaning(25);
  const FloorPlane rolled{true, {static_cast<float>(std::sin(a)), static_cast<float>(-std::cos(a)), 0}, 970};
  EXPECT_FALSE(has(pose_gate(joints, rolled), Guidance::not_upright));
}

// Joints straighten a bent person: the lean seen decides, where it is seen.
TEST(PoseGate, TheLeanSeenDecides) {
  const GuidanceSet bent = static_cast<GuidanceSet>(Guidance::not_upright);
  EXPECT_EQ(pose_gate(standing(), kLevelFloor, ViewSide::front, {true, 0.3F}), bent);
  EXPECT_EQ(pose_gate(bowing(25), kLevelFloor, ViewSide::front, {true, 0.05F}), 0U);
  EXPECT_EQ(pose_gate(bowing(25), kLevelFloor, ViewSide::front, {false, 0.05F}), bent);
}

TEST(PoseGate, TheDirectionABentPersonFacesIsNotJudged) {
  for (const ViewSide view : {ViewSide::side, ViewSide::unknown}) {
    EXPECT_EQ(pose_gate(standing(), kLevelFloor, view, {true, 0.3F}),
              static_cast<GuidanceSet>(Guidance::not_upright));
    EXPECT_EQ(pose_gate(standing(), kLevelFloor, view, {true, 0.05F}),
              static_cast<GuidanceSet>(Guidance::not_frontal));
  }
}

// Hands before the body are hidden hands put where hands mostly are.
TEST(PoseGate, AnUnsureHandNeedsMoreRoom) {
  for (const auto& [hand, hip] : {std::pair{Joint::LA, Joint::LH}, std::pair{Joint::RA, Joint::RH}}) {
    JointSet joints = standing();
    const float outwards = joints[hand].x > 0 ? 1.0F : -1.0F;
    joints[hand].x = joints[hip].x + outwards * 150;
    EXPECT_EQ(pose_gate(joints, kLevelFloor), 0U);
    joints.confidence[joint_index(hand)] = 0.2F;
    EXPECT_EQ(pose_gate(joints, kLevelFloor), static_cast<GuidanceSet>(Guidance::arms_close));
    joints[hand].x = joints[hip].x + outwards * 260;
    EXPECT_EQ(pose_gate(joints, kLevelFloor), 0U);
  }
}

TEST(PoseGate, AHandOnTheHipIsTooClose) {
  JointSet joints = standing();
  joints[Joint::LA].x = joints[Joint::LH].x + 30;
  EXPECT_EQ(pose_gate(joints, kLevelFloor), static_cast<GuidanceSet>(Guidance::arms_close));
}

}  // namespace
}  // namespace im2fit
