// SPDX-License-Identifier: Apache-2.0
#include "body/fit/limb_axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "body/fit/shape_fitter.h"
#include "seen_person.h"

namespace im2fit::body {
namespace {

// Turned by an angle about the upright axis, from x towards -z, then about the z axis of before, from x towards y.
Mat3f turned(float about_y, float about_z) {
  const float cy = std::cos(about_y), sy = std::sin(about_y), cz = std::cos(about_z), sz = std::sin(about_z);
  Mat3f m;
  m.m = {cy * cz, -cy * sz, sy, sz, cz, 0, -sy * cz, sy * sz, cy};
  return m;
}

constexpr std::size_t kUpperArm = 3;  // of the left, in kGirthLimbs
static_assert(kGirthLimbs[kUpperArm / 3] == Segment::left_upper_arm);

TEST(LimbAxes, FollowALimbAndNotTheFacingDirection) {
  constexpr float kPi = 3.14159265F;
  for (const float facing : {0.0F, 0.3F, kPi / 2, kPi}) {
    Pose pose;
    for (Mat3f& r : pose.rotation) r = turned(facing, 0);
    const LimbAxes straight = limb_axes(pose);
    for (std::size_t i = 0; i < kLimbValues; ++i) EXPECT_NEAR(straight[i], i % 3 == 0 ? 1 : 0, 1e-6F) << i;
    // An arm raised by 30 degrees, and one brought forward by 20.
    pose.rotation[static_cast<std::size_t>(Segment::left_upper_arm)] = turned(facing, kPi / 6);
    LimbAxes axes = limb_axes(pose);
    EXPECT_NEAR(axes[kUpperArm], std::cos(kPi / 6), 1e-6F);
    EXPECT_NEAR(axes[kUpperArm + 1], 0.5F, 1e-6F);
    EXPECT_NEAR(axes[kUpperArm + 2], 0, 1e-6F);
    pose.rotation[static_cast<std::size_t>(Segment::left_upper_arm)] = turned(facing - kPi / 9, 0);
    axes = limb_axes(pose);
    EXPECT_NEAR(axes[kUpperArm], std::cos(kPi / 9), 1e-6F);
    EXPECT_NEAR(axes[kUpperArm + 1], 0, 1e-6F);
    EXPECT_NEAR(axes[kUpperArm + 2], std::sin(kPi / 9), 1e-6F);
    for (std::size_t i = 0; i < kLimbValues; ++i) EXPECT_TRUE(i / 3 == kUpperArm / 3 || axes[i] == straight[i]) << i;
  }
}

TEST(LimbAxes, OfAPelvisThatLiesOnItsSidePointUpAlone) {
  Pose pose;
  for (Mat3f& r : pose.rotation) r.m = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  const LimbAxes axes = limb_axes(pose);
  for (std::size_t i = 0; i < kLimbValues; ++i) EXPECT_EQ(axes[i], i % 3 == 1 ? 1 : 0) << i;
}

// The same person with arms at 12 and at 30 degrees: the fit says in which direction each upper arm moved, in both
// views.
TEST(LimbAxes, OfAFitSayHowArmsAreHeld) {
  IM2FIT_NEEDS_SPACE();
  ShapeFitter fitter(real_body()->shape_space());
  std::array<std::array<LimbAxes, kFitViewMax>, 2> seen;
  constexpr std::array kSpreadDeg = {12.0F, 30.0F};
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const SeenPerson person(*real_body(), lab::Family::held_out, 515, 4, 2400, kSpreadDeg[i]);
    const ShapeFit& fit = fitter.run(person.views);
    ASSERT_TRUE(fit.valid);
    seen[i] = fit.limbs;
    for (const float v : fitter.first_alone().limbs[1]) EXPECT_TRUE(std::isnan(v));
  }
  const std::size_t at =
      3 * static_cast<std::size_t>(std::find(kGirthLimbs.begin(), kGirthLimbs.end(), Segment::right_upper_arm) -
                                   kGirthLimbs.begin());
  for (std::size_t v = 0; v < kFitViewMax; ++v) {
    // Along the arms x points outwards on the left and inwards on the right: raised, it turns up there and down here.
    const auto raised_deg = [&](std::size_t value, std::size_t i) {
      return std::asin(static_cast<double>(seen[i][v][value])) * 180 / 3.14159265;
    };
    EXPECT_NEAR(raised_deg(kUpperArm + 1, 1) - raised_deg(kUpperArm + 1, 0), 18, 4) << v;
    EXPECT_NEAR(raised_deg(at + 1, 1) - raised_deg(at + 1, 0), -18, 4) << v;
  }
}

}  // namespace
}  // namespace im2fit::body
