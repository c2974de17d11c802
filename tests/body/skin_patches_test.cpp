// SPDX-License-Identifier: Apache-2.0
#include "body/fit/skin_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "body/fit/shape_fitter.h"
#include "fake_shape_space.h"
#include "seen_person.h"

namespace im2fit::body {
namespace {

// A dent in the belly that no shape of the space has: the depth picture shows it, and so does the patch over it.
// (Patches are larger than the dent, and the shape gives in a little.)
TEST(SkinPatches, SayWhereAFitIsOff) {
  IM2FIT_NEEDS_SPACE();
  const ShapeSpace& space = real_body()->shape_space();
  ShapeFitter fitter(space);
  SeenPerson person(*real_body(), lab::Family::held_out, 515, 2);
  const auto front = std::span(person.views).first(1);
  const ShapeFit before = fitter.run(front);
  ASSERT_TRUE(before.valid);
  for (const float off : before.off_mm[1]) EXPECT_TRUE(std::isnan(off));
  std::vector<Vec3f> points(space.point_count);
  fitter.points_in_view(0, points);
  // Where the belly's middle is seen: between hips and torso, nearest the camera there.
  const auto patch = skin_patches(space);
  const JointSet& joints = person.views[0].joints;
  const float height = (joints[Joint::TO].y + joints[Joint::LH].y) / 2;
  std::size_t navel = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::fabs(points[i].y - height) < 40 && std::fabs(points[i].x) < 40 && points[i].z < points[navel].z)
      navel = i;
  constexpr float kDentMm = 25, kReachMm = 60;
  const Intrinsics& k = person.views[0].intrinsics;
  for (int v = 0; v < SeenPerson::kHeight; ++v)
    for (int u = 0; u < SeenPerson::kWidth; ++u) {
      const auto at = static_cast<std::size_t>(v * SeenPerson::kWidth + u);
      const float z = static_cast<float>(person.depth_q4[0][at]) / 16;
      const float x = (static_cast<float>(u) - k.cx) * z / k.fx - points[navel].x;
      const float y = (static_cast<float>(v) - k.cy) * z / k.fy - points[navel].y;
      if (z > 0 && x * x + y * y < kReachMm * kReachMm)
        person.depth_q4[0][at] = static_cast<std::uint16_t>(person.depth_q4[0][at] + 16 * kDentMm);
    }
  const ShapeFit after = fitter.run(front);
  ASSERT_TRUE(after.valid);
  double elsewhere = 0;
  float deepest = 0;
  int seen = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3f away = points[i] - points[navel];
    const float off = after.off_mm[0][patch[i]] - before.off_mm[0][patch[i]];
    if (norm(away) < kReachMm) deepest = std::min(deepest, off);
    if (norm(away) < 400 || !std::isfinite(off)) continue;
    elsewhere += static_cast<double>(std::fabs(off));
    ++seen;
  }
  ASSERT_GT(seen, 200);
  EXPECT_LT(deepest, -kDentMm / 5);
  EXPECT_LT(elsewhere / seen, 1);
}

TEST(SkinPatches, CoverTheSkinEvenlyAndNoneIsEmpty) {
  const ShapeSpace space = fake_shape_space();
  const auto patch = skin_patches(space);
  ASSERT_EQ(patch.size(), space.point_count);
  std::vector<int> members(patch_count(space));
  for (const std::uint16_t p : patch) {
    ASSERT_LT(p, members.size());
    ++members[p];
  }
  EXPECT_EQ(std::count(members.begin(), members.end(), 0), 0);

  IM2FIT_NEEDS_SPACE();
  const ShapeSpace& real = real_body()->shape_space();
  const auto of = skin_patches(real);
  members.assign(patch_count(real), 0);
  std::vector<float> low(members.size(), 1e9F), high(members.size(), -1e9F);
  for (std::size_t i = 0; i < of.size(); ++i) {
    ++members[of[i]];
    const float y = real.point_mean[i * kPointValues + 1];
    low[of[i]] = std::min(low[of[i]], y);
    high[of[i]] = std::max(high[of[i]], y);
  }
  for (std::size_t p = 0; p < members.size(); ++p) {
    EXPECT_GT(members[p], 0) << p;
    EXPECT_LT(high[p] - low[p], 250) << p;  // mm: 160 patches of 1.8 square metres
  }
}

}  // namespace
}  // namespace im2fit::body
