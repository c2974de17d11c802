// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/guidance.h"
#include "train/dataset/features.h"

namespace im2fit::lab {
namespace {

TEST(CaptureDraws, VaryAsGivenAndRepeat) {
  CaptureVariety variety;
  int wide = 0, landscape = 0, anywhere = 0, far = 0;
  for (std::uint64_t s = 0; s < 2000; ++s) {
    const CaptureOptions a = draw_capture(variety, 1, s, 0);
    const CaptureOptions b = draw_capture(variety, 1, s, 0);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.frame_count, b.frame_count);
    EXPECT_NE(a.seed, draw_capture(variety, 1, s, 1).seed);
    EXPECT_NE(a.seed, draw_capture(variety, 2, s, 0).seed);
    EXPECT_GE(a.frame_count, variety.frames_min);
    EXPECT_LE(a.frame_count, variety.frames_max);
    EXPECT_NEAR(a.sensor.depth_scale, 1, 0.003001);
    wide += a.intrinsics.width == 640 ? 1 : 0;
    landscape += a.scene.rotate_deg == 0 ? 1 : 0;
    anywhere += a.scene.distance_mm > 0 ? 1 : 0;
    far += a.scene.distance_mm > 3300 ? 1 : 0;
    EXPECT_EQ(a.scene.enlarge_to_fit, a.scene.distance_mm > 0);
    EXPECT_LE(a.scene.distance_mm, kTooFarMm);
  }
  EXPECT_NEAR(anywhere / 2000.0, variety.anywhere_share, 0.04);
  EXPECT_NEAR(far / 2000.0, variety.anywhere_share / 3, 0.03);
  EXPECT_NEAR(wide / 2000.0, variety.wide_share, 0.03);
  EXPECT_NEAR(landscape / 2000.0, variety.landscape_share, 0.04);
}

TEST(CaptureDraws, AFewSensorsAreNoKinect) {
  const CaptureVariety variety;
  constexpr int kDraws = 4000;
  int tof = 0, exact = 0, wide = 0;
  for (std::uint64_t s = 0; s < kDraws; ++s) {
    const CaptureOptions drawn = draw_capture(variety, 5, s, 0);
    SensorOptions sensor = drawn.sensor;
    sensor.depth_scale = 1;
    if (sensor == kinect_sensor()) continue;
    EXPECT_TRUE(sensor == tof_sensor() || sensor == exact_sensor());
    (sensor == tof_sensor() ? tof : exact) += 1;
    wide += drawn.intrinsics.width == 640 ? 1 : 0;
  }
  EXPECT_NEAR(tof, kDraws * variety.other_sensor_share / 2, 50);
  EXPECT_NEAR(exact, kDraws * variety.other_sensor_share / 2, 50);
  EXPECT_GT(wide, 2 * variety.wide_share * (tof + exact));
}

TEST(FeatureGroups, CoverTheFeature) {
  std::size_t covered = 0;
  for (const auto& g : feature_groups()) covered += g.count;
  EXPECT_EQ(covered, kFeatureSize);
}

}  // namespace
}  // namespace im2fit::lab
