// SPDX-License-Identifier: Apache-2.0
// Outlines spoilt as drivers spoil them, by the sums written down here, and put back to where they were.
#include "perception/observe/edge_restorer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <vector>

#include "core/rng.h"

namespace im2fit {
namespace {

constexpr int kWidth = 192, kHeight = 256;
constexpr float kFocalPx = 230, kRadiusPx = 60;
constexpr double kRoundPx = 2 * 3.14159 * static_cast<double>(kRadiusPx);  // a pixel's width all round
constexpr int kNearMm = 2300, kWallMm = 3300;

// A disc before a wall.
struct Disc {
  explicit Disc(int wall_mm = kWallMm, int near_mm = kNearMm) : pixels(kWidth * kHeight) {
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const float x = static_cast<float>(u) - 95.3F, y = static_cast<float>(v) - 127.6F;
        image().at(u, v) = static_cast<std::uint16_t>(x * x + y * y < kRadiusPx * kRadiusPx ? near_mm : wall_mm);
      }
  }
  DepthImage image() { return {pixels.data(), kWidth, kHeight}; }
  // As far as a mask follows a surface.
  double near_count() const {
    return static_cast<double>(std::count_if(
        pixels.begin(), pixels.end(), [](std::uint16_t mm) { return mm >= kNearMm - 40 && mm <= kNearMm + 40; }));
  }
  std::vector<std::uint16_t> pixels;
};

// The mean of pixels with data within `reach_px`.
void blend(Disc& disc, int reach_px) {
  Disc before = disc;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      int sum_mm = 0, count = 0;
      for (int y = std::max(0, v - reach_px); y <= std::min(kHeight - 1, v + reach_px); ++y)
        for (int x = std::max(0, u - reach_px); x <= std::min(kWidth - 1, u + reach_px); ++x) {
          sum_mm += before.image().at(x, y);
          count += before.image().at(x, y) != 0 ? 1 : 0;
        }
      if (before.image().at(u, v) != 0) disc.image().at(u, v) = static_cast<std::uint16_t>(sum_mm / count);
    }
}

// No data beside steps of a tenth of a metre and more, and beside the end of the visible surface.
void drop(Disc& disc, int reach_px) {
  Disc before = disc;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      for (int y = std::max(0, v - reach_px); y <= std::min(kHeight - 1, v + reach_px); ++y)
        for (int x = std::max(0, u - reach_px); x <= std::min(kWidth - 1, u + reach_px); ++x)
          if (std::abs(before.image().at(x, y) - before.image().at(u, v)) > 100) disc.image().at(u, v) = 0;
}

void add_noise(Disc& disc, double sd_mm) {
  Rng rng(11);
  for (std::uint16_t& mm : disc.pixels)
    if (mm != 0) mm = static_cast<std::uint16_t>(std::lround(mm + sd_mm * rng.normal()));
}

TEST(EdgeRestorer, BlendedOutlinesComeBack) {
  for (const int reach_px : {1, 2})
    for (const double noise_mm : {0.0, 4.0}) {
      Disc disc;
      const double sharp = disc.near_count();
      blend(disc, reach_px);
      add_noise(disc, noise_mm);
      EXPECT_LT(disc.near_count(), sharp - 0.5 * kRoundPx * reach_px);
      EdgeRestorer restorer(kWidth, kHeight);
      restorer.run(disc.image(), kFocalPx);
      EXPECT_TRUE(restorer.restored());
      EXPECT_NEAR(disc.near_count(), sharp, 0.1 * kRoundPx) << reach_px << " " << noise_mm;
    }
}

TEST(EdgeRestorer, DroppedOutlinesComeBack) {
  for (const int reach_px : {1, 2}) {
    Disc disc;
    const double sharp = disc.near_count();
    drop(disc, reach_px);
    EXPECT_LT(disc.near_count(), sharp - 0.9 * kRoundPx * reach_px);
    EdgeRestorer restorer(kWidth, kHeight);
    restorer.run(disc.image(), kFocalPx);
    EXPECT_TRUE(restorer.restored());
    EXPECT_NEAR(disc.near_count(), sharp, 0.25 * kRoundPx) << reach_px;
  }
}

// In a picture 256 pixels high a blend of 3x3 is not wider than the restored rim, one of 5x5 is.
TEST(EdgeRestorer, WideBlendsAreBeyondRepair) {
  for (const auto& [reach_px, focal_px, beyond] :
       {std::tuple{1, kFocalPx, false}, {2, kFocalPx, true}, {2, 2 * kFocalPx, false}, {0, kFocalPx, false}}) {
    Disc disc;
    blend(disc, reach_px);
    EdgeRestorer restorer(kWidth, kHeight);
    restorer.run(disc.image(), focal_px);
    EXPECT_EQ(restorer.beyond_repair(), beyond) << reach_px << " " << focal_px;
  }
}

// Learned before a wall, an outline is grown before nothing, too.
TEST(EdgeRestorer, DroppedOutlinesGrowBeforeNothing) {
  EdgeRestorer restorer(kWidth, kHeight);
  Disc before_wall;
  drop(before_wall, 1);
  restorer.run(before_wall.image(), kFocalPx);
  Disc alone(0);
  const double sharp = alone.near_count();
  drop(alone, 1);
  EXPECT_LT(alone.near_count(), sharp - 0.9 * kRoundPx);
  restorer.run(alone.image(), kFocalPx);
  EXPECT_NEAR(alone.near_count(), sharp, 0.6 * kRoundPx);
}

TEST(EdgeRestorer, SharpPicturesStayToTheBit) {
  for (const int wall_mm : {kWallMm, 0, kNearMm + 100})
    for (const double noise_mm : {0.0, 8.0}) {
      Disc disc(wall_mm);
      add_noise(disc, noise_mm);
      const std::vector<std::uint16_t> sharp = disc.pixels;
      EdgeRestorer restorer(kWidth, kHeight);
      for (int i = 0; i < 3; ++i) restorer.run(disc.image(), kFocalPx);
      EXPECT_FALSE(restorer.restored());
      EXPECT_EQ(disc.pixels, sharp);
    }
}

// A projector's shadow: no data on one side alone.
TEST(EdgeRestorer, AShadowIsNoDroppedEdge) {
  Disc disc;
  const DepthImage image = disc.image();
  for (int v = 0; v < kHeight; ++v)
    for (int u = kWidth - 1; u > 6; --u)
      if (image.at(u, v) == kWallMm && image.at(u - 6, v) == kNearMm) image.at(u, v) = 0;
  const std::vector<std::uint16_t> sharp = disc.pixels;
  EdgeRestorer restorer(kWidth, kHeight);
  restorer.run(image, kFocalPx);
  EXPECT_FALSE(restorer.restored());
  EXPECT_EQ(disc.pixels, sharp);
}

// Only parts of a line where near and far lie together are looked through: a long step counts wherever it begins.
TEST(EdgeRestorer, AStepCountsWhereverItLies) {
  constexpr int kLong = 640, kRows = 8, kStepPx = 22;
  for (const bool noisy : {false, true})
    for (int begin = 1; begin + kStepPx < kLong; ++begin) {
      std::vector<std::uint16_t> pixels(kLong * kRows);
      for (int v = 0; v < kRows; ++v)
        for (int u = 0; u < kLong; ++u) {
          const int slope_mm = kNearMm + (kWallMm - kNearMm) * std::clamp(u - begin, 0, kStepPx) / kStepPx;
          const int noise_mm = noisy && u > begin + kStepPx && u % 2 != 0 ? 70 : 0;
          pixels[static_cast<std::size_t>(v * kLong + u)] = static_cast<std::uint16_t>(slope_mm + noise_mm);
        }
      EdgeRestorer restorer(kLong, kRows);
      restorer.run({pixels.data(), kLong, kRows}, 575);
      ASSERT_EQ(restorer.counts().steps, 2) << "of two rows of eight, from pixel " << begin;
    }
}

TEST(EdgeRestorer, AFloorIsNoStep) {
  // A camera 1.2 m above a floor that fills the picture from the horizon on.
  std::vector<std::uint16_t> pixels(kWidth * kHeight);
  const DepthImage image(pixels.data(), kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) image.at(u, v) = static_cast<std::uint16_t>(v > 60 ? 230 * 1200 / (v - 12) : 0);
  EdgeRestorer restorer(kWidth, kHeight);
  restorer.run(image, kFocalPx);
  EXPECT_EQ(restorer.counts().steps, 0U);
}

TEST(EdgeRestorer, ForgetsAndHandlesAnything) {
  EdgeRestorer restorer(kWidth, kHeight);
  Disc disc;
  blend(disc, 1);
  restorer.run(disc.image(), kFocalPx);
  EXPECT_TRUE(restorer.restored());
  restorer.reset();
  EXPECT_FALSE(restorer.restored());
  EXPECT_EQ(restorer.counts().steps, 0U);
  Rng rng(5);
  for (int round = 0; round < 20; ++round) {
    for (std::uint16_t& mm : disc.pixels) {
      const double chance = rng.uniform();
      const int any = rng.index(std::numeric_limits<std::uint16_t>::max() + 1);
      mm = static_cast<std::uint16_t>(chance < 0.3 ? 0 : chance < 0.4 ? 65535 : any);
    }
    restorer.run(disc.image(), kFocalPx);
  }
}

}  // namespace
}  // namespace im2fit
