// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/sensor_traits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace im2fit {
namespace {

enum Trait : std::size_t { kNoise, kPixel, kSilent, kSilentPixel, kTof, kTofPixel };
constexpr float kFocalPx = 575.8F;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
// Losses beside outlines as three sensors have them before a wall, and none measured.
constexpr SensorSigns kKinectLosses{0, 0.27F, 0.36F}, kTofLosses{0, 0.13F, 0.03F}, kNoLosses{0, 0, 0},
    kUnseen{0, kNaN, 0};
SensorSigns with_noise(SensorSigns losses, float noise_mm) {
  losses.noise_mm = noise_mm;
  return losses;
}

// Worked by hand: Nguyen's 1.2 + 1.9 (z - 0.4)^2 is 6.064, 14.044 and 25.824 mm at 2, 3 and 4 m.
TEST(SensorTraits, AKinectIsNeitherSilentNorTimeOfFlight) {
  for (const SensorSigns& losses : {kKinectLosses, kUnseen})
    for (const auto& [z_mm, noise_mm] : {std::pair{2000.0F, 6.064F}, {3000.0F, 14.044F}, {4000.0F, 25.824F}})
      for (const float seen : {0.72F, 0.85F, 1.0F, 1.3F}) {  // differences beyond 50 mm do not count: less is seen
        const auto traits = sensor_traits(with_noise(losses, seen * noise_mm), z_mm, kFocalPx);
        EXPECT_EQ(traits[kSilent], 0) << z_mm;
        EXPECT_LT(traits[kTof], 0.25F) << z_mm << " " << seen;
        EXPECT_GE(traits[kNoise], seen * noise_mm);
        if (seen > 0.8F) {
          EXPECT_EQ(traits[kTof], 0) << z_mm << " " << seen;
        }
      }
}

// 2 + 0.3 z^2: 3.2, 4.7 and 6.8 mm.
TEST(SensorTraits, TimeOfFlightIsRecognised) {
  for (const SensorSigns& losses : {kTofLosses, kUnseen})
    for (const auto& [z_mm, noise_mm] : {std::pair{2000.0F, 3.2F}, {3000.0F, 4.7F}, {4000.0F, 6.8F}})
      for (const float seen : {0.8F, 1.0F, 1.1F}) {
        const auto traits = sensor_traits(with_noise(losses, seen * noise_mm), z_mm, kFocalPx);
        EXPECT_EQ(traits[kSilent], 0);
        EXPECT_EQ(traits[kTof], 1) << z_mm << " " << seen;
        EXPECT_FLOAT_EQ(traits[kTofPixel], z_mm / kFocalPx);
        EXPECT_FLOAT_EQ(traits[kNoise], seen * noise_mm);
      }
}

TEST(SensorTraits, NoNoiseIsRecognised) {
  for (const SensorSigns& losses : {kNoLosses, kUnseen})
    for (const float noise_mm : {0.0F, 0.3F, 1.0F}) {
      const auto traits = sensor_traits(with_noise(losses, noise_mm), 2300, kFocalPx);
      EXPECT_EQ(traits[kNoise], noise_mm);
      EXPECT_EQ(traits[kSilent], 1);
      EXPECT_EQ(traits[kTof], 0);
      EXPECT_FLOAT_EQ(traits[kSilentPixel], 2300 / kFocalPx);
      EXPECT_EQ(traits[kTofPixel], 0);
    }
  EXPECT_FLOAT_EQ(sensor_traits(with_noise(kNoLosses, 1.5F), 2300, kFocalPx)[kSilent], 0.5F);
  EXPECT_FLOAT_EQ(sensor_traits(with_noise(kNoLosses, 1.5F), 2300, kFocalPx)[kTof], 0.5F);
}

// A driver that smooths over time hides the noise, not the losses. Least noise by hand: half way from 3.587
// to 8.059 mm at 2.3 m, and 0.8 of 3.587.
TEST(SensorTraits, SmoothedSensorsAreKnownByWhatTheyLose) {
  for (const float noise_mm : {0.0F, 0.8F, 1.8F, 3.2F}) {
    const auto kinect = sensor_traits(with_noise(kKinectLosses, noise_mm), 2300, kFocalPx);
    EXPECT_NEAR(kinect[kNoise], 5.823F, 1e-3F);
    for (const Trait t : {kSilent, kSilentPixel, kTof, kTofPixel}) EXPECT_EQ(kinect[t], 0) << t;
    const auto tof = sensor_traits(with_noise(kTofLosses, noise_mm), 2300, kFocalPx);
    EXPECT_NEAR(tof[kNoise], std::max(noise_mm, 2.870F), 1e-3F);
    EXPECT_EQ(tof[kSilent], 0);
    EXPECT_EQ(tof[kTof], 1);
  }
}

TEST(SensorTraits, KindsShareOutOneAndChangeGently) {
  for (const float z_mm : {500.0F, 1200.0F, 1800.0F, 2600.0F, 4000.0F}) {
    for (const SensorSigns& losses : {kKinectLosses, kTofLosses, kNoLosses, kUnseen}) {
      auto before = sensor_traits(losses, z_mm, kFocalPx);
      for (float noise_mm = 0; noise_mm < 40; noise_mm += 0.01F) {
        const auto traits = sensor_traits(with_noise(losses, noise_mm), z_mm, kFocalPx);
        EXPECT_GE(traits[kTof], 0);
        EXPECT_GE(traits[kSilent], 0);
        EXPECT_LE(traits[kSilent] + traits[kTof], 1.0001F);
        EXPECT_NEAR(traits[kTof], before[kTof], 0.04F) << z_mm << " " << noise_mm;
        before = traits;
      }
    }
    for (const float noise_mm : {0.2F, 3.5F, 9.0F}) {
      auto before = sensor_traits({noise_mm, 0, 0}, z_mm, kFocalPx);
      for (float share = 0; share < 0.5F; share += 0.0005F) {
        const auto traits = sensor_traits({noise_mm, share, share}, z_mm, kFocalPx);
        EXPECT_NEAR(traits[kTof], before[kTof], 0.015F) << z_mm << " " << noise_mm << " " << share;
        EXPECT_NEAR(traits[kSilent], before[kSilent], 0.015F);
        before = traits;
      }
    }
  }
}

TEST(SensorTraits, AKnownKindIsTakenAtItsWord) {
  constexpr float kWidth = 2300 / kFocalPx;
  for (const SensorSigns& losses : {kKinectLosses, kTofLosses, kNoLosses, kUnseen}) {
    for (const float noise_mm : {0.0F, 1.5F, 3.2F, 5.0F, kNaN}) {
      const auto traits = sensor_traits(with_noise(losses, noise_mm), 2300, kFocalPx, SensorKind::structured_light);
      EXPECT_NEAR(traits[kNoise], 5.823F, 1e-3F);
      EXPECT_FLOAT_EQ(traits[kPixel], kWidth);
      for (const Trait t : {kSilent, kSilentPixel, kTof, kTofPixel}) EXPECT_EQ(traits[t], 0) << t;
    }
    for (const float noise_mm : {0.0F, 1.5F, kNaN}) {
      const auto traits = sensor_traits(with_noise(losses, noise_mm), 2300, kFocalPx, SensorKind::time_of_flight);
      EXPECT_NEAR(traits[kNoise], 2.870F, 1e-3F);
      EXPECT_EQ(traits[kSilent], 0);
      EXPECT_EQ(traits[kTof], 1);
      EXPECT_FLOAT_EQ(traits[kTofPixel], kWidth);
    }
  }
  EXPECT_EQ(sensor_traits({9, kNaN, 0}, 2300, kFocalPx, SensorKind::structured_light)[kNoise], 9);
  for (const SensorSigns& losses : {kKinectLosses, kTofLosses, kNoLosses, kUnseen})
    EXPECT_EQ(sensor_traits(with_noise(losses, 3.2F), 2300, kFocalPx, SensorKind::stereo),
              sensor_traits(with_noise(losses, 3.2F), 2300, kFocalPx, SensorKind::structured_light));
  EXPECT_EQ(sensor_traits({12, kNaN, 0}, 2300, kFocalPx, SensorKind::time_of_flight)[kTof], 1);
}

TEST(SensorTraits, OneFrameIsKnownByWhatItLoses) {
  const auto kinect = sensor_traits(with_noise(kKinectLosses, kNaN), 2300, kFocalPx);
  EXPECT_NEAR(kinect[kNoise], 5.823F, 1e-3F);
  EXPECT_EQ(kinect[kTof] + kinect[kSilent], 0);
  EXPECT_EQ(sensor_traits(with_noise(kTofLosses, kNaN), 2300, kFocalPx)[kTof], 1);
  const auto exact = sensor_traits(with_noise(kNoLosses, kNaN), 2300, kFocalPx);
  EXPECT_EQ(exact[kSilent], 1);
  EXPECT_EQ(exact[kNoise], 0);
}

TEST(SensorTraits, NothingMeasuredLeavesThemUnknown) {
  const auto traits = sensor_traits({kNaN, kNaN, 0}, 2300, kFocalPx);
  for (const Trait t : {kNoise, kSilent, kSilentPixel, kTof, kTofPixel}) EXPECT_TRUE(std::isnan(traits[t])) << t;
  EXPECT_FLOAT_EQ(traits[kPixel], 2300 / kFocalPx);
}

}  // namespace
}  // namespace im2fit
