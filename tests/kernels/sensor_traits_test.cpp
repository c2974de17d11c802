// SPDX-License-Identifier: Apache-2.0
#include "kernels/observe/sensor_traits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace im2fit {
namespace {

enum Trait : std::size_t { kNoise, kPixel, kSilent, kSilentPixel, kTof, kTofPixel };
constexpr float kFocalPx = 575.8F;

// Worked by hand: Nguyen's 1.2 + 1.9 (z - 0.4)^2 is 6.064, 14.044 and 25.824 mm at 2, 3 and 4 m.
TEST(SensorTraits, AKinectIsNeitherSilentNorTimeOfFlight) {
  for (const auto& [z_mm, noise_mm] : {std::pair{2000.0F, 6.064F}, {3000.0F, 14.044F}, {4000.0F, 25.824F}})
    for (const float seen :
         {0.72F, 0.85F, 1.0F, 1.3F}) {  // differences beyond 50 mm do not count, so that less is seen
      const auto traits = sensor_traits(seen * noise_mm, z_mm, kFocalPx);
      EXPECT_EQ(traits[kSilent], 0) << z_mm;
      EXPECT_LT(traits[kTof], 0.25F) << z_mm << " " << seen;
      if (seen > 0.8F) {
        EXPECT_EQ(traits[kTof], 0) << z_mm << " " << seen;
      }
    }
}

// 2 + 0.3 z^2: 3.2, 4.7 and 6.8 mm.
TEST(SensorTraits, TimeOfFlightIsTold) {
  for (const auto& [z_mm, noise_mm] : {std::pair{2000.0F, 3.2F}, {3000.0F, 4.7F}, {4000.0F, 6.8F}})
    for (const float seen : {0.8F, 1.0F, 1.1F}) {
      const auto traits = sensor_traits(seen * noise_mm, z_mm, kFocalPx);
      EXPECT_EQ(traits[kSilent], 0);
      EXPECT_EQ(traits[kTof], 1) << z_mm << " " << seen;
      EXPECT_FLOAT_EQ(traits[kTofPixel], z_mm / kFocalPx);
    }
}

TEST(SensorTraits, NoNoiseIsTold) {
  for (const float noise_mm : {0.0F, 0.3F, 1.0F}) {
    const auto traits = sensor_traits(noise_mm, 2300, kFocalPx);
    EXPECT_EQ(traits[kNoise], noise_mm);
    EXPECT_EQ(traits[kSilent], 1);
    EXPECT_EQ(traits[kTof], 0);
    EXPECT_FLOAT_EQ(traits[kSilentPixel], 2300 / kFocalPx);
    EXPECT_EQ(traits[kTofPixel], 0);
  }
  EXPECT_FLOAT_EQ(sensor_traits(1.5F, 2300, kFocalPx)[kSilent], 0.5F);
  EXPECT_FLOAT_EQ(sensor_traits(1.5F, 2300, kFocalPx)[kTof], 0.5F);
}

TEST(SensorTraits, KindsShareOutOneAndChangeGently) {
  for (const float z_mm : {500.0F, 1200.0F, 1800.0F, 2600.0F, 4000.0F}) {
    auto before = sensor_traits(0, z_mm, kFocalPx);
    for (float noise_mm = 0; noise_mm < 40; noise_mm += 0.01F) {
      const auto traits = sensor_traits(noise_mm, z_mm, kFocalPx);
      EXPECT_GE(traits[kTof], 0);
      EXPECT_LE(traits[kSilent] + traits[kTof], 1.0001F);
      EXPECT_NEAR(traits[kTof], before[kTof], 0.04F) << z_mm << " " << noise_mm;
      before = traits;
    }
  }
}

TEST(SensorTraits, UnknownNoiseLeavesThemUnknown) {
  const auto traits = sensor_traits(std::numeric_limits<float>::quiet_NaN(), 2300, kFocalPx);
  for (const Trait t : {kNoise, kSilent, kSilentPixel, kTof, kTofPixel}) EXPECT_TRUE(std::isnan(traits[t])) << t;
  EXPECT_FLOAT_EQ(traits[kPixel], 2300 / kFocalPx);
}

// Worked by hand as above: half way from 3.587 to 8.059 mm at 2.3 m, and 0.8 of 3.587.
TEST(SensorTraits, AKnownKindIsTakenAtItsWord) {
  constexpr float kWidth = 2300 / kFocalPx;
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const float noise_mm : {0.0F, 1.5F, 3.2F, 5.0F, kNaN}) {
    const auto traits = sensor_traits(noise_mm, 2300, kFocalPx, SensorKind::structured_light);
    EXPECT_NEAR(traits[kNoise], 5.823F, 1e-3F);
    EXPECT_FLOAT_EQ(traits[kPixel], kWidth);
    for (const Trait t : {kSilent, kSilentPixel, kTof, kTofPixel}) EXPECT_EQ(traits[t], 0) << t;
  }
  EXPECT_EQ(sensor_traits(9, 2300, kFocalPx, SensorKind::structured_light)[kNoise], 9);
  for (const float noise_mm : {0.0F, 1.5F, kNaN}) {
    const auto traits = sensor_traits(noise_mm, 2300, kFocalPx, SensorKind::time_of_flight);
    EXPECT_NEAR(traits[kNoise], 2.870F, 1e-3F);
    EXPECT_EQ(traits[kSilent], 0);
    EXPECT_EQ(traits[kTof], 1);
    EXPECT_FLOAT_EQ(traits[kTofPixel], kWidth);
  }
  EXPECT_EQ(sensor_traits(12, 2300, kFocalPx, SensorKind::time_of_flight)[kTof], 1);
}

}  // namespace
}  // namespace im2fit
