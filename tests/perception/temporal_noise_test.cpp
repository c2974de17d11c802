// SPDX-License-Identifier: Apache-2.0
// Against noise of a known spread.
#include "perception/fuse/temporal_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/rng.h"
#include "kernels/average/average.h"

namespace im2fit {
namespace {

constexpr int kWidth = 96, kHeight = 80;

struct Frame {
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight, 2000);
  std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(kWidth * kHeight, 255);
  DepthView depth_view() const { return {depth.data(), kWidth, kHeight}; }
  MaskView mask_view() const { return {mask.data(), kWidth, kHeight}; }
};

void add(TemporalNoise& noise, const Frame& f) {
  noise.add(f.depth_view(), f.mask_view(), 0, 0, kWidth - 1, kHeight - 1);
}

float measured(double sd_mm, int frame_count, Rng& rng) {
  TemporalNoise noise(kWidth, kHeight);
  Frame f;
  for (int i = 0; i < frame_count; ++i) {
    for (auto& z : f.depth) z = static_cast<std::uint16_t>(std::lround(2000 + sd_mm * rng.normal()));
    add(noise, f);
  }
  return noise.sd_mm();
}

TEST(TemporalNoise, FindsTheSpreadItWasDrawnBy) {
  Rng rng(7);
  for (const double sd_mm : {0.0, 1.5, 4.0, 8.0, 12.0})
    for (const int frames : {2, 3, 9, 30}) {
      const double whole_mm = sd_mm > 0 ? std::hypot(sd_mm, std::sqrt(1.0 / 12)) : 0;
      EXPECT_NEAR(measured(sd_mm, frames, rng), whole_mm, 0.06 * sd_mm) << sd_mm << " of " << frames;
    }
}

TEST(TemporalNoise, WidensWithinWhatCountsAsTheSameSurface) {
  Rng rng(8);
  // 25 mm: one difference in six is beyond kOutlierMm, so that less is seen than there is, but more than of 12.
  const float much = measured(25, 9, rng);
  EXPECT_GT(much, 15);
  EXPECT_LT(much, 25);
}

TEST(TemporalNoise, OneFrameLeavesItUnknown) {
  Rng rng(9);
  EXPECT_TRUE(std::isnan(measured(5, 1, rng)));
  TemporalNoise noise(kWidth, kHeight);
  EXPECT_TRUE(std::isnan(noise.sd_mm()));
}

TEST(TemporalNoise, ReadsMaskedPixelsOfTheBoxAndOneSurfaceAlone) {
  TemporalNoise noise(kWidth, kHeight);
  Frame f;
  constexpr int kLeft = 10, kRight = 70, kTop = 5, kBottom = 60;
  for (int i = 0; i < 4; ++i) {
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const std::size_t at = static_cast<std::size_t>(v * kWidth + u);
        const bool inside = u >= kLeft && u <= kRight && v >= kTop && v <= kBottom;
        // Outside the box and the mask, and of pixels that see another surface by turns, anything.
        f.depth[at] = static_cast<std::uint16_t>(!inside      ? 2000 + 20 * i
                                                 : u % 5 == 0 ? 2000 + (i % 2) * (static_cast<int>(kOutlierMm) + 1)
                                                 : u % 5 == 1 ? 2000 + 30 * i
                                                              : 2000 + 4 * (i % 2));
        f.mask[at] = u % 5 == 1 ? 0 : 255;
      }
    noise.add(f.depth_view(), f.mask_view(), kLeft, kTop, kRight, kBottom);
  }
  EXPECT_NEAR(noise.sd_mm(), 4 * 0.5 * std::sqrt(3.14159265), 1e-4);
  noise.reset();
  EXPECT_TRUE(std::isnan(noise.sd_mm()));
}

TEST(TemporalNoise, ABoxBeyondThePictureIsCut) {
  TemporalNoise noise(kWidth, kHeight);
  Frame f;
  for (int i = 0; i < 2; ++i) {
    std::fill(f.depth.begin(), f.depth.end(), static_cast<std::uint16_t>(2000 + 6 * i));
    noise.add(f.depth_view(), f.mask_view(), -20, -3, kWidth + 50, kHeight + 9);
  }
  EXPECT_NEAR(noise.sd_mm(), 6 * 0.5 * std::sqrt(3.14159265), 1e-4);
  noise.add(f.depth_view(), f.mask_view(), kWidth, 0, kWidth + 5, kHeight);  // empty
}

// A recording whose frames come twice is of the same camera.
TEST(TemporalNoise, FramesMayComeTwice) {
  TemporalNoise noise(kWidth, kHeight);
  Frame f;
  for (const int z : {2000, 2000, 2012, 2012, 2012, 2000}) {
    std::fill(f.depth.begin(), f.depth.end(), static_cast<std::uint16_t>(z));
    add(noise, f);
    if (z == 2000) continue;
    EXPECT_NEAR(noise.sd_mm(), 12 * 0.5 * std::sqrt(3.14159265), 1e-4);
  }
}

// A pixel lost for a frame is compared with when it was seen last.
TEST(TemporalNoise, PixelsMayBlink) {
  TemporalNoise noise(kWidth, kHeight);
  Frame f;
  for (const int z : {2000, 0, 2010}) {
    std::fill(f.depth.begin(), f.depth.end(), static_cast<std::uint16_t>(z));
    add(noise, f);
  }
  EXPECT_NEAR(noise.sd_mm(), 10 * 0.5 * std::sqrt(3.14159265), 1e-4);
}

}  // namespace
}  // namespace im2fit
