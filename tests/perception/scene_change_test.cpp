// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/scene_change.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/rng.h"

namespace im2fit {
namespace {

constexpr int kWide = 640;
constexpr int kHigh = 480;

// A wall, and noise of a Kinect's SD at its depth.
struct Scene {
  explicit Scene(int z_mm, std::uint64_t seed = 1) : pixels(kWide * kHigh) {
    Rng rng(seed);
    const double sd_mm = 1.425e-6 * z_mm * z_mm;
    for (std::uint16_t& p : pixels) p = static_cast<std::uint16_t>(z_mm + sd_mm * rng.normal());
  }
  Scene& box(int u0, int v0, int width, int height, std::uint16_t z_mm) {
    for (int v = v0; v < v0 + height; ++v)
      for (int u = u0; u < u0 + width; ++u) pixels[static_cast<std::size_t>(v * kWide + u)] = z_mm;
    return *this;
  }
  DepthView view() const { return {pixels.data(), kWide, kHigh}; }
  std::vector<std::uint16_t> pixels;
};

TEST(SceneChange, IsSaidUntilAPictureIsKept) {
  SceneChange change(kWide, kHigh);
  const Scene wall(3000);
  EXPECT_TRUE(change.changed(wall.view()));
  change.keep(wall.view());
  EXPECT_FALSE(change.changed(wall.view()));
  change.forget();
  EXPECT_TRUE(change.changed(wall.view()));
}

TEST(SceneChange, IsNotTheSensorsNoise) {
  for (const int z_mm : {800, 2000, 4000, 8000}) {
    SceneChange change(kWide, kHigh);
    change.keep(Scene(z_mm).view());
    for (std::uint64_t seed = 2; seed < 8; ++seed)
      ASSERT_FALSE(change.changed(Scene(z_mm, seed).view())) << z_mm << " mm, seed " << seed;
  }
}

// An arm's breadth of a person 0.4 m before the wall, wherever it comes in.
TEST(SceneChange, IsALimbThatComesIntoThePicture) {
  SceneChange change(kWide, kHigh);
  change.keep(Scene(4000).view());
  for (int u = 0; u <= kWide - 40; u += 29)
    for (const int v : {0, 99, kHigh - 120})
      ASSERT_TRUE(change.changed(Scene(4000, 3).box(u, v, 40, 120, 3600).view())) << u << ", " << v;
}

TEST(SceneChange, IsDataLostOrGained) {
  SceneChange change(kWide, kHigh);
  change.keep(Scene(2000).view());
  EXPECT_TRUE(change.changed(Scene(2000).box(300, 200, 64, 64, 0).view()));
  EXPECT_FALSE(change.changed(Scene(2000).box(300, 200, 64, 8, 0).view())) << "a shadow's edge flickers";
  change.keep(Scene(2000).box(300, 200, 64, 64, 0).view());
  EXPECT_TRUE(change.changed(Scene(2000).view()));
}

// Pictures of any size, smaller than a block too.
TEST(SceneChange, HasNoSmallestPicture) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {5, 700}, {2048, 9}}) {
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(width * height), 1000);
    const DepthView view(pixels.data(), width, height);
    SceneChange change(width, height);
    change.keep(view);
    EXPECT_FALSE(change.changed(view)) << width << "x" << height;
  }
}

}  // namespace
}  // namespace im2fit
