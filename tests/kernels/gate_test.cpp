// SPDX-License-Identifier: Apache-2.0
// Poses set by hand; the gate must name what is wrong with each and nothing else.
#include "kernels/observe/gate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/kernels/analytic_figure.h"

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
  EXPECT_EQ(pose_gate(turned(8), kLevelFloor), 0U) << "nobody stands quite square";
}

TEST(PoseGate, TurnedIsNotFrontal) {
  EXPECT_EQ(pose_gate(turned(35), kLevelFloor), static_cast<GuidanceSet>(Guidance::not_frontal));
  EXPECT_EQ(pose_gate(turned(-35), kLevelFloor), static_cast<GuidanceSet>(Guidance::not_frontal));
}

TEST(PoseGate, LeaningIsNotUpright) {
  EXPECT_TRUE(has(pose_gate(leaning(25), kLevelFloor), Guidance::not_upright));
  EXPECT_FALSE(has(pose_gate(leaning(8), kLevelFloor), Guidance::not_upright));
}

TEST(PoseGate, UprightMeansAgainstTheFloorNotThePicture) {
  // The camera rolls by 25 degrees: picture and floor lean together.
  const double a = 25 * 0.017453292519943295;
  JointSet joints = leaning(25);
  const FloorPlane rolled{true, {static_cast<float>(std::sin(a)), static_cast<float>(-std::cos(a)), 0}, 970};
  EXPECT_FALSE(has(pose_gate(joints, rolled), Guidance::not_upright));
}

TEST(PoseGate, AHandOnTheHipIsTooClose) {
  JointSet joints = standing();
  joints[Joint::LA].x = joints[Joint::LH].x + 30;
  EXPECT_EQ(pose_gate(joints, kLevelFloor), static_cast<GuidanceSet>(Guidance::arms_close));
}

}  // namespace
}  // namespace im2fit
