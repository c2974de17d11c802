// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/rng.h"
#include "kernels/rayform/ray_form.h"

namespace im2fit {
namespace {

// Against axis . p in double. Tables are within 2^-28.4 twice, times 4096 mm; the product rounds to 2^-11 mm.
TEST(RayForm, IsTheCoordinateAlongTheAxis) {
  constexpr int kWidth = 101, kHeight = 77;
  Rng rng(5);
  for (int turn = 0; turn < 30; ++turn) {
    // Half of the cameras are far wider than any sensor: slopes up to the limit of 4.
    const float focal = turn % 2 == 0 ? 90.0F : 13.0F;
    const Intrinsics k = {kWidth, kHeight, focal, focal * 1.01F, 50.25F, 40};
    RayTable rays(kWidth, kHeight);
    set_camera(rays, k);
    const Vec3f axis = turn < 6 ? Vec3f{turn % 3 == 0 ? 1.0F : 0, turn % 3 == 1 ? -1.0F : 0, turn % 3 == 2 ? 1.0F : 0}
                                : normalized(Vec3f{rng.fast_normal(), rng.fast_normal(), rng.fast_normal()});
    RayForm form(kWidth, kHeight);
    form.set(rays, axis);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const auto depth = static_cast<std::uint16_t>(rng.index(4) == 0 ? 65535 : 1 + rng.index(65535));
        const double z = depth / 16.0, x = (u - double{k.cx}) / double{k.fx} * z,
                     y = (v - double{k.cy}) / double{k.fy} * z;
        const double truth = double{axis.x} * x + double{axis.y} * y + double{axis.z} * z;
        const std::int32_t got = form_product(form.columns()[u] + form.rows()[v], depth);
        ASSERT_NEAR(got / 1024.0, truth, 1.0 / 2048 + 2.4e-5) << u << ' ' << v << " turn " << turn;
      }
    }
  }
}

TEST(RayForm, OffsetsAreBounded) {
  EXPECT_EQ(form_offset(1.5), 1536);
  EXPECT_EQ(form_offset(-0.0004), 0);
  EXPECT_EQ(form_offset(1e12), kFormOffsetMax);
  EXPECT_EQ(form_offset(-1e12), -kFormOffsetMax);
  EXPECT_EQ(form_offset(std::numeric_limits<double>::quiet_NaN()), 0);
}

// A camera that changed in any of its numbers gets its own tables.
TEST(RayForm, TablesFollowTheCamera) {
  RayTable rays(50, 40);
  Intrinsics k = {50, 40, 60, 60, 24.5F, 19.5F};
  set_camera(rays, k);
  const RaySlope before = rays.column(3);
  k.cx += 1;
  set_camera(rays, k);
  EXPECT_NE(rays.column(3), before);
  k.cx -= 1;
  set_camera(rays, k);
  EXPECT_EQ(rays.column(3), before);
}

}  // namespace
}  // namespace im2fit
