// SPDX-License-Identifier: Apache-2.0
// Against geometry: a disc before a wall, and points beside it, behind something and out of reach.
#include "perception/joints/snap_to_mask.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace im2fit::joints {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr Intrinsics kCamera{kWidth, kHeight, 288, 288, 159.5F, 119.5F};
constexpr int kDiscMm = 2000, kWallMm = 3000, kBoardMm = 1500;
constexpr float kRadiusMm = 150;
constexpr float kPixelMm = 2000.0F / 288;

class SnappedJoint : public testing::Test {
 protected:
  SnappedJoint() {
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const auto [x, y] = at(u, v);
        const bool disc = x * x + y * y < kRadiusMm * kRadiusMm;
        const bool board = x < -120 && !disc;
        const auto i = static_cast<std::size_t>(v * kWidth + u);
        depth_[i] = static_cast<std::uint16_t>(disc ? kDiscMm : board ? kBoardMm : y > 400 ? 0 : kWallMm);
        mask_[i] = disc ? 1 : 0;
      }
    Person person;
    person.found = true;
    person.u_max = kWidth - 1;
    person.v_max = kHeight - 1;
    ok_ = downsample(depth(), {mask_.data(), kWidth, kHeight}, kCamera, person, view_);
  }
  struct Place {
    float x, y;
  };
  static Place at(int u, int v) {
    return {(static_cast<float>(u) - kCamera.cx) * kPixelMm, (static_cast<float>(v) - kCamera.cy) * kPixelMm};
  }
  DepthView depth() const { return {depth_.data(), kWidth, kHeight}; }
  Vec3f snap(Vec3f p) const { return snap_to_mask(p, view_, depth(), kCamera); }

  std::vector<std::uint16_t> depth_ = std::vector<std::uint16_t>(kWidth * kHeight);
  std::vector<std::uint8_t> mask_ = std::vector<std::uint8_t>(kWidth * kHeight);
  View view_;
  bool ok_ = false;
};

TEST_F(SnappedJoint, BesideTheMaskGoesToTheNearestOfIt) {
  ASSERT_TRUE(ok_);
  for (const float angle : {-1.2F, -0.6F, 0.0F, 0.4F, 1.1F}) {
    const Vec3f direction{std::cos(angle), std::sin(angle), 0};
    const Vec3f p = snap(direction * (kRadiusMm + 70) + Vec3f{0, 0, kDiscMm});
    EXPECT_NEAR(std::hypot(p.x, p.y), kRadiusMm, 1.5F * kPixelMm) << angle;
    EXPECT_NEAR(p.x * direction.y - p.y * direction.x, 0, 3 * kPixelMm) << angle;
    EXPECT_EQ(p.z, kDiscMm);
  }
}

TEST_F(SnappedJoint, OnTheMaskStays) {
  const Vec3f p = snap({30, -80, kDiscMm + 60});
  EXPECT_EQ(p.x, 30);
  EXPECT_EQ(p.y, -80);
}

TEST_F(SnappedJoint, BehindSomethingNearerStays) {
  const Vec3f p = snap({-(kRadiusMm + 60), 0, kDiscMm});
  EXPECT_EQ(p.x, -(kRadiusMm + 60));
}

TEST_F(SnappedJoint, OutOfReachStays) {
  const Vec3f p = snap({kRadiusMm + kSnapReachMm + 20, 0, kDiscMm});
  EXPECT_EQ(p.x, kRadiusMm + kSnapReachMm + 20);
}

TEST_F(SnappedJoint, AtThePicturesBorderStays) {
  const Vec3f beyond{0, 900, kDiscMm};
  EXPECT_EQ(snap(beyond).y, beyond.y);
  const Vec3f behind{10, 10, -kDiscMm};  // a joint model may say anything
  EXPECT_TRUE(std::isfinite(snap(behind).x));
}

}  // namespace
}  // namespace im2fit::joints
