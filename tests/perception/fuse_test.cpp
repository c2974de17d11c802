// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/rng.h"
#include "perception/fuse/decimate.h"
#include "perception/fuse/depth_fusion.h"

namespace im2fit {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

struct Frame {
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight);
  std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(kWidth * kHeight, 255);
  DepthView depth_view() const { return {depth.data(), kWidth, kHeight}; }
  MaskView mask_view() const { return {mask.data(), kWidth, kHeight}; }
};

void add(DepthFusion& fusion, const Frame& f) {
  fusion.add(f.depth_view(), f.mask_view(), 0, 0, kWidth - 1, kHeight - 1);
}

TEST(DepthFusion, MeanKeepsASixteenthOfAMillimetre) {
  DepthFusion fusion(kWidth, kHeight);
  Frame f;
  for (const int z : {2000, 2001, 2001, 2003}) {
    std::fill(f.depth.begin(), f.depth.end(), static_cast<std::uint16_t>(z));
    add(fusion, f);
  }
  fusion.finish();
  EXPECT_EQ(fusion.depth_q4().at(5, 7), static_cast<std::uint16_t>(2001.25 * 16));
}

TEST(DepthFusion, NoiseFallsWithTheRootOfTheFrameCount) {
  DepthFusion fusion(kWidth, kHeight);
  Frame f;
  Rng rng(3);
  for (int frame = 0; frame < 16; ++frame) {
    for (auto& z : f.depth) z = static_cast<std::uint16_t>(std::lround(2200 + 6 * rng.normal()));
    add(fusion, f);
  }
  fusion.finish();
  double square = 0;
  for (int i = 0; i < kWidth * kHeight; ++i) square += std::pow(fusion.depth_q4().pixels[i] / 16.0 - 2200.0, 2);
  const double sd = std::sqrt(square / (kWidth * kHeight));
  EXPECT_NEAR(sd, 6.0 / 4.0, 0.15);
}

TEST(DepthFusion, AnotherSurfaceAndRarePixelsAreLeftOut) {
  DepthFusion fusion(kWidth, kHeight);
  Frame f;
  for (int frame = 0; frame < 5; ++frame) {
    std::fill(f.depth.begin(), f.depth.end(), std::uint16_t{2000});
    if (frame == 4) f.depth[0] = 2500;  // an arm's way behind
    f.mask[1] = frame < 2 ? 255 : 0;    // in two frames of five
    f.depth[2] = frame < 3 ? std::uint16_t{2000} : std::uint16_t{0};
    add(fusion, f);
  }
  fusion.finish();
  EXPECT_EQ(fusion.depth_q4().pixels[0], 2000 * 16);
  EXPECT_EQ(fusion.mask().pixels[1], 0);
  EXPECT_EQ(fusion.mask().pixels[2], 255);
}

TEST(Decimate, GridPointsLieOnTheTiltedPlaneTheyCameFrom) {
  const Intrinsics k{kWidth, kHeight, 60.0F, 60.0F, 31.5F, 23.5F};
  std::vector<std::uint16_t> depth(kWidth * kHeight);
  std::vector<std::uint8_t> mask(kWidth * kHeight, 255);
  // z = 2000 + 0.2 x in the camera's frame: z (1 - 0.2 (u-cx)/fx) = 2000.
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double slope = 0.2 * (u - 31.5) / 60.0;
      depth[static_cast<std::size_t>(v * kWidth + u)] =
          static_cast<std::uint16_t>(std::lround(2000.0 / (1.0 - slope) * 16.0));
    }
  const int step = 4;
  const Intrinsics grid = grid_intrinsics(k, step);
  ASSERT_EQ(grid.width, 16);
  std::vector<float> x(16 * 12), y(16 * 12), z(16 * 12);
  decimate({depth.data(), kWidth, kHeight}, {mask.data(), kWidth, kHeight}, grid, step, x, y, z);
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (std::isnan(z[i])) continue;
    EXPECT_NEAR(z[i], 2000.0F + 0.2F * x[i], 8.0F) << i;  // a block spans 27 mm of slope; its mean lies mid-way
  }
  EXPECT_FALSE(std::isnan(z[0]));
}

// A grid point is in the middle of its pixels: the ray through the pixels' mean is the grid's.
TEST(Decimate, AGridPointIsInTheMiddleOfItsPixels) {
  const Intrinsics k{640, 480, 575.0F, 570.0F, 319.5F, 239.5F};
  const Intrinsics grid = grid_intrinsics(k, 4);
  EXPECT_FLOAT_EQ((10 - grid.cx) / grid.fx, (41.5F - k.cx) / k.fx);
  EXPECT_FLOAT_EQ((7 - grid.cy) / grid.fy, (29.5F - k.cy) / k.fy);
}

TEST(Decimate, StepBringsTheGridToTwentyMillimetres) {
  const Intrinsics k{640, 480, 575.8F, 575.8F, 319.5F, 239.5F};
  EXPECT_EQ(grid_step_px(k, 2303.0F), 5);
  EXPECT_EQ(grid_step_px({320, 240, 287.9F, 287.9F, 159.5F, 119.5F}, 2303.0F), 3);
  EXPECT_EQ(grid_step_px(k, 0.0F), 1);
  EXPECT_EQ(grid_step_px(k, 100.0F), 16);
}

}  // namespace
}  // namespace im2fit
