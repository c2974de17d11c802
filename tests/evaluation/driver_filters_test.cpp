// SPDX-License-Identifier: Apache-2.0
// What drivers do beside edges, by the sums written down here, and over time, by the equation of exponential
// smoothing.
#include "evaluation/measurements/driver_filters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/rng.h"
#include "perception/fuse/temporal_noise.h"

namespace im2fit::lab {
namespace {

using Row = std::vector<std::uint16_t>;

// The middle row of a picture whose rows are all alike.
Row filtered(const Row& row, const EdgeFilterOptions& options) {
  constexpr int kHeight = 9;
  const int width = static_cast<int>(row.size());
  std::vector<std::uint16_t> pixels;
  for (int v = 0; v < kHeight; ++v) pixels.insert(pixels.end(), row.begin(), row.end());
  EdgeFilter(options).run({pixels.data(), width, kHeight});
  const auto middle = pixels.begin() + kHeight / 2 * width;
  return {middle, middle + width};
}

const Row kStep = {2000, 2000, 2000, 2000, 2000, 2600, 2600, 2600, 2600, 2600};

TEST(EdgeFilter, MeansBridgeASurfaceToTheOther) {
  EXPECT_EQ(filtered(kStep, {}), kStep);
  EXPECT_EQ(filtered(kStep, {EdgeBlend::mean3}), (Row{2000, 2000, 2000, 2000, 2200, 2400, 2600, 2600, 2600, 2600}));
  EXPECT_EQ(filtered(kStep, {EdgeBlend::mean5}), (Row{2000, 2000, 2000, 2120, 2240, 2360, 2480, 2600, 2600, 2600}));
}

TEST(EdgeFilter, ABilateralFilterKeepsASharpStep) {
  const Row kept = filtered(kStep, {EdgeBlend::bilateral5});
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_NEAR(kept[i], kStep[i], 1) << i;
}

TEST(EdgeFilter, HalfTheResolutionMeetsHalfway) {
  EXPECT_EQ(filtered(kStep, {EdgeBlend::bilinear2}),
            (Row{2000, 2000, 2000, 2000, 2000, 2300, 2600, 2600, 2600, 2600}));
}

TEST(EdgeFilter, NoDataStaysAndIsNotBlended) {
  Row step = kStep;
  step[5] = 0;
  EXPECT_EQ(filtered(step, {EdgeBlend::mean3}), (Row{2000, 2000, 2000, 2000, 2000, 0, 2600, 2600, 2600, 2600}));
}

TEST(EdgeFilter, LowConfidenceIsAPixelOnEitherSide) {
  EXPECT_EQ(filtered(kStep, {EdgeBlend::none, true}), (Row{2000, 2000, 2000, 2000, 0, 0, 2600, 2600, 2600, 2600}));
  EXPECT_EQ(filtered({2000, 2000, 2090, 2090, 2090}, {EdgeBlend::none, true}), (Row{2000, 2000, 2090, 2090, 2090}));
}

TEST(TemporalSmoothing, MovesAQuarterOfTheWay) {
  std::uint16_t pixel = 2000;
  const DepthImage frame(&pixel, 1, 1);
  TemporalSmoothing smoothing;
  smoothing.run(frame);
  EXPECT_EQ(pixel, 2000);
  double expected = 2000;
  for (int i = 0; i < 20; ++i) {
    pixel = 2040;
    smoothing.run(frame);
    expected += (2040 - expected) / 4;
    EXPECT_EQ(pixel, std::lround(expected)) << i;
  }
}

TEST(TemporalSmoothing, AnotherSurfaceAndALostPixelBeginAnew) {
  TemporalSmoothing smoothing;
  for (const auto& [delivered, smoothed] :
       {std::pair{2000, 2000}, {2100, 2100}, {2104, 2101}, {0, 0}, {2010, 2010}}) {
    auto pixel = static_cast<std::uint16_t>(delivered);
    smoothing.run({&pixel, 1, 1});
    EXPECT_EQ(pixel, smoothed) << delivered;
  }
}

// White noise s comes out as s sqrt(a / (2 - a)), and from frame to frame changes as if it were s a / sqrt(2 - a).
TEST(TemporalSmoothing, HidesWhatTellsASensor) {
  constexpr int kWidth = 160, kHeight = 120;
  constexpr double kSdMm = 8, kShare = TemporalSmoothing::kShare;
  Rng rng(3);
  TemporalSmoothing smoothing;
  TemporalNoise noise(kWidth, kHeight);
  std::vector<std::uint16_t> depth(kWidth * kHeight);
  const std::vector<std::uint8_t> mask(depth.size(), 255);
  const DepthImage frame(depth.data(), kWidth, kHeight);
  double square = 0;
  for (int i = 0; i < 40; ++i) {
    for (auto& z : depth) z = static_cast<std::uint16_t>(std::lround(2000 + kSdMm * rng.normal()));
    smoothing.run(frame);
    if (i < 20) continue;  // converged
    noise.add(frame, {mask.data(), kWidth, kHeight}, 0, 0, kWidth - 1, kHeight - 1);
    for (const auto z : depth) square += (z - 2000.0) * (z - 2000.0) / (20.0 * static_cast<double>(depth.size()));
  }
  EXPECT_NEAR(std::sqrt(square), kSdMm * std::sqrt(kShare / (2 - kShare)), 0.1);
  EXPECT_NEAR(noise.sd_mm(), kSdMm * kShare / std::sqrt(2 - kShare), 0.1);
}

}  // namespace
}  // namespace im2fit::lab
