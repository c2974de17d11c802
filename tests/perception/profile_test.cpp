// SPDX-License-Identifier: Apache-2.0
// Truth: closed-form geometry of an upright cylinder seen by a level camera.
#include "perception/profile/profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace im2fit {
namespace {

using L = ProfileLayout;
constexpr int kWidth = 480;
constexpr int kHeight = 640;
constexpr float kFocal = 575.8F;
constexpr double kRadius = 150;
constexpr double kDistance = 2300;
constexpr double kCameraHeight = 1000;
constexpr double kTop = 1700;

class CylinderProfile : public ::testing::Test {
 protected:
  CylinderProfile() : depth(kWidth * kHeight), mask(kWidth * kHeight), out(L::kSize) {
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        // Ray (x, y, 1) t meets x^2 + (z - D)^2 = R^2.
        const double x = (u - 239.5) / kFocal;
        const double y = (v - 319.5) / kFocal;
        const double a = 1 + x * x;
        const double discriminant = kDistance * kDistance - a * (kDistance * kDistance - kRadius * kRadius);
        if (discriminant < 0) continue;
        const double z = (kDistance - std::sqrt(discriminant)) / a;
        const double height = kCameraHeight - y * z;
        if (height < 0 || height > kTop) continue;
        depth[static_cast<std::size_t>(v * kWidth + u)] = static_cast<std::uint16_t>(std::lround(z * 16));
        mask[static_cast<std::size_t>(v * kWidth + u)] = 255;
      }
    }
    floor = {true, {0, -1, 0}, static_cast<float>(kCameraHeight)};
    const auto put = [&](Joint j, double side, double height) {
      joints[j] = {static_cast<float>(side), static_cast<float>(kCameraHeight - height),
                   static_cast<float>(kDistance)};
    };
    using enum Joint;
    put(HE, 0, 1600), put(NE, 0, 1450), put(TO, 0, 1200);
    put(LS, 180, 1420), put(RS, -180, 1420), put(LE, 330, 1150), put(RE, -330, 1150);
    put(LA, 420, 900), put(RA, -420, 900), put(LH, 90, 950), put(RH, -90, 950);
    put(LK, 90, 500), put(RK, -90, 500), put(LF, 90, 80), put(RF, -90, 80);
  }
  void run(bool floor_known = true) {
    floor.known = floor_known;
    ProfileWorkspace work;
    section_profile({depth.data(), kWidth, kHeight}, {mask.data(), kWidth, kHeight},
                    {kWidth, kHeight, kFocal, kFocal, 239.5F, 319.5F}, joints, floor, work, out);
  }
  float value(int at) const { return out[static_cast<std::size_t>(at)]; }

  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  std::vector<float> out;
  JointSet joints;
  FloorPlane floor;
};

TEST_F(CylinderProfile, HalfWidthsAreTheSilhouettesTangents) {
  run();
  const double tangent = kRadius * std::sqrt(1 - kRadius * kRadius / (kDistance * kDistance));
  for (int level = 2; level < 16; ++level) {
    EXPECT_NEAR(value(L::kTrunk + level * L::kTrunkValues), tangent, 2.0) << level;
    EXPECT_NEAR(value(L::kTrunk + level * L::kTrunkValues + 1), tangent, 2.0) << level;
  }
}

TEST_F(CylinderProfile, ReliefFollowsTheCircle) {
  run();
  const int at = L::kTrunk + 8 * L::kTrunkValues + 2;
  const auto fall = [](double part) { return kRadius * (1 - std::sqrt(1 - part * part)); };
  // Differences between neighbouring reliefs do not depend on the level's own zero.
  EXPECT_NEAR(value(at + 4) - value(at), fall(0.8), 3.0);
  EXPECT_NEAR(value(at + 4) - value(at + 2), fall(0.4), 2.0);
  EXPECT_NEAR(value(at + 6) - value(at + 2), 0.0, 2.0);  // half a pixel to one side
  EXPECT_NEAR(value(at + L::kReliefs), 2 * kRadius * std::asin(0.8), 8.0);
}

TEST_F(CylinderProfile, CrownAndSolesCountFromTheFloor) {
  run();
  // 1500 mm^2 of a 300 mm wide front begin 5 mm below the top edge; the head's 280 mm are read.
  EXPECT_NEAR(value(L::kCrown + 2), kTop - 1500.0 / 280.0, 4.0);
  EXPECT_NEAR(value(L::kSoles + 1), 1500.0 / 300.0, 4.0);
}

TEST_F(CylinderProfile, WithoutAFloorHeightsCountFromTheSoles) {
  run();
  const float with_floor = value(L::kCrown + 1);
  run(false);
  EXPECT_NEAR(value(L::kCrown + 1), with_floor, 4.0F);
}

TEST_F(CylinderProfile, LegsOfOneRunMeetInTheMiddle) {
  run();
  const int at = L::kLegs + 10 * L::kLegValues;
  EXPECT_NEAR(value(at), kRadius, 3.0);
  EXPECT_NEAR(value(at + 1), kRadius, 3.0);
}

TEST_F(CylinderProfile, AJointThatIsNowhereGivesNothing) {
  for (const Joint joint : {Joint::TO, Joint::HE}) {
    const Vec3f was = joints[joint];
    for (const float broken : {std::nanf(""), 1e30F}) {
      joints[joint].x = broken;
      run();
      for (const float v : out) EXPECT_TRUE(std::isnan(v));
    }
    joints[joint] = was;
  }
}

// Pixels that are masked but hold no depth do not count as crown or soles.
TEST_F(CylinderProfile, MaskWithoutDepthChangesNothing) {
  run();
  const std::vector<float> before = out;
  for (std::size_t i = 0; i < kWidth; i += 3) mask[i] = mask[mask.size() - 1 - i] = 255;
  run();
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(std::isnan(out[i]), std::isnan(before[i])) << i;
    if (std::isnan(before[i])) continue;
    EXPECT_EQ(out[i], before[i]) << i;
  }
}

TEST_F(CylinderProfile, AnEmptyMaskGivesNothing) {
  std::fill(mask.begin(), mask.end(), std::uint8_t{0});
  run();
  for (const float v : out) EXPECT_TRUE(std::isnan(v));
}

}  // namespace
}  // namespace im2fit
