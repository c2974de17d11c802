// SPDX-License-Identifier: Apache-2.0
// Figures of ellipsoids and capsules with their arms where the test wants them: the gap between arm and trunk.
#include "perception/observe/arm_gap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/perception/analytic_figure.h"

namespace im2fit {
namespace {

constexpr float kDistanceMm = 2300;
constexpr ArmSet kBoth = kLeftArm | kRightArm;

// A picture of a figure alone: the mask is where it is.
struct Shown {
  Intrinsics k;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  JointSet joints;
  ArmSet joined() const {
    return arms_joined({depth.data(), k.width, k.height}, {mask.data(), k.width, k.height}, k, joints);
  }
};

Shown show(const test::Figure& figure, int width = 480) {
  const auto scale = static_cast<float>(width) / 480;
  Shown s;
  s.k = {width, width * 4 / 3, 575.8F * scale, 575.8F * scale, 239.5F * scale, 319.5F * scale};
  const auto count = static_cast<std::size_t>(s.k.width) * static_cast<std::size_t>(s.k.height);
  s.depth.assign(count, 0);
  s.mask.assign(count, 0);
  for (int v = 0; v < s.k.height; ++v) {
    for (int u = 0; u < s.k.width; ++u) {
      const double z = figure
                           .cast_ray((u - static_cast<double>(s.k.cx)) / static_cast<double>(s.k.fx),
                                     (v - static_cast<double>(s.k.cy)) / static_cast<double>(s.k.fy))
                           .z;
      const auto at = static_cast<std::size_t>(v) * static_cast<std::size_t>(s.k.width) + static_cast<std::size_t>(u);
      if (z <= 0) continue;
      s.depth[at] = static_cast<std::uint16_t>(z + 0.5);
      s.mask[at] = 255;
    }
  }
  s.joints = figure.joints;
  return s;
}

// The standing figure with this arm turned about its shoulder: `out_deg` from hanging down, `forward_deg` of the
// forearm towards the camera. Arms are the capsules 2 to 5 of the figure.
void set_arm(test::Figure& f, bool left, double out_deg, double forward_deg = 0) {
  constexpr double kPerDeg = 0.017453292519943295;
  const float side = left ? 1.0F : -1.0F;
  const Vec3f shoulder = f.joints[left ? Joint::LS : Joint::RS];
  const auto out = static_cast<float>(std::sin(out_deg * kPerDeg));
  const auto down = static_cast<float>(std::cos(out_deg * kPerDeg));
  const auto fore = static_cast<float>(std::sin(forward_deg * kPerDeg));
  const auto level = static_cast<float>(std::cos(forward_deg * kPerDeg));
  const Vec3f elbow = shoulder + Vec3f{side * out * 290, down * 290, 0};
  const Vec3f hand = elbow + Vec3f{side * out * level * 270, down * level * 270, -fore * 270};
  f.capsules[left ? 3 : 2] = {shoulder, elbow, 45};
  f.capsules[left ? 5 : 4] = {elbow, hand, 38};
  f.joints[left ? Joint::LE : Joint::RE] = elbow;
  f.joints[left ? Joint::LA : Joint::RA] = hand;
}
test::Figure with_arms(double left_deg, double right_deg, double forward_deg = 0) {
  test::Figure f = test::standing_figure(0, kDistanceMm);
  set_arm(f, true, left_deg, forward_deg);
  set_arm(f, false, right_deg, forward_deg);
  return f;
}

TEST(ArmGap, ArmsHeldOffTheBodyAreApart) {
  for (const int degrees : {14, 20, 35, 50})
    for (const int width : {480, 240}) EXPECT_EQ(show(with_arms(degrees, degrees), width).joined(), 0U) << degrees;
}

TEST(ArmGap, HangingArmsAreJoined) {
  for (const int degrees : {-3, 0, 3})
    for (const int width : {480, 240}) EXPECT_EQ(show(with_arms(degrees, degrees), width).joined(), kBoth) << degrees;
}

TEST(ArmGap, NamesTheArm) {
  EXPECT_EQ(show(with_arms(0, 30)).joined(), kLeftArm);
  EXPECT_EQ(show(with_arms(30, 0)).joined(), kRightArm);
}

TEST(ArmGap, SeenFromBehindLeftAndRightAreStillThePersons) {
  Shown s = show(with_arms(0, 30));
  for (const auto& [a, b] : {std::pair{Joint::LS, Joint::RS}, std::pair{Joint::LE, Joint::RE},
                             std::pair{Joint::LA, Joint::RA}, std::pair{Joint::LH, Joint::RH}})
    std::swap(s.joints[a], s.joints[b]);
  EXPECT_EQ(s.joined(), kRightArm);
}

TEST(ArmGap, JointsThatErrDoNotHideIt) {
  Shown s = show(with_arms(0, 0));
  s.joints[Joint::LA].x += 150;  // where hands mostly are
  s.joints[Joint::RA].x -= 150;
  s.joints[Joint::LE].x += 60;
  EXPECT_EQ(s.joined(), kBoth);
}

TEST(ArmGap, AForearmBeforeTheBodyIsNotApart) {
  test::Figure f = with_arms(30, 30);
  // The left hand on the belly.
  f.capsules[5] = {f.joints[Joint::LE], {0, -100, kDistanceMm - 170}, 38};
  f.joints[Joint::LA] = {0, -100, kDistanceMm - 170};
  EXPECT_EQ(show(f).joined() & kLeftArm, kLeftArm);
}

TEST(ArmGap, HandsOnTheHipsAreJoinedThoughTheWaistIsFree) {
  test::Figure f = with_arms(40, 40);
  for (const bool left : {true, false}) {
    const float side = left ? 1.0F : -1.0F;
    const Vec3f hip = {side * 190, 30, kDistanceMm};
    f.capsules[left ? 5 : 4] = {f.joints[left ? Joint::LE : Joint::RE], hip, 38};
    f.joints[left ? Joint::LA : Joint::RA] = hip;
  }
  EXPECT_EQ(show(f).joined(), kBoth);
}

TEST(ArmGap, LevelArmsAreAway) {
  EXPECT_EQ(show(with_arms(90, 90)).joined(), 0U);
  EXPECT_EQ(show(with_arms(80, 20)).joined(), 0U);
}

TEST(ArmGap, AGapIsNotMadeByAHoleInTheTrunk) {
  Shown s = show(with_arms(0, 0));
  for (int v = 0; v < s.k.height; ++v)
    for (int u = 245; u < 253; ++u)  // 32 mm wide, beside the spine
      s.mask[static_cast<std::size_t>(v) * static_cast<std::size_t>(s.k.width) + static_cast<std::size_t>(u)] = 0;
  EXPECT_EQ(s.joined(), kBoth);
}

TEST(ArmGap, NothingIsSaidWithoutAPerson) {
  Shown s = show(with_arms(0, 0));
  s.joints = {};
  EXPECT_EQ(s.joined(), 0U);
  s = show(with_arms(0, 0));
  s.joints[Joint::LS].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(s.joined(), 0U);
  s = show(with_arms(0, 0));
  for (Vec3f& p : s.joints.position_mm) p = p * 1e-6F;
  EXPECT_EQ(s.joined(), 0U);
  s = show(with_arms(0, 0));
  for (Vec3f& p : s.joints.position_mm) p.x += 1e8F;
  EXPECT_EQ(s.joined(), 0U) << "outside the picture";
}

}  // namespace
}  // namespace im2fit
