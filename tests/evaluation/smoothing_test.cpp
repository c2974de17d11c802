// SPDX-License-Identifier: Apache-2.0
// A smoothing driver, by the law of exponential smoothing.
#include "evaluation/measurements/smoothing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/rng.h"
#include "perception/fuse/temporal_noise.h"

namespace im2fit::lab {
namespace {

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
