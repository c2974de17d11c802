// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/guidance.h"
#include "hal/source.h"
#include "tests/train/tracker_fixture.h"
#include "train/dataset/features.h"

namespace im2fit::lab {
namespace {

// As on the device: each frame is sensed.
struct FrameByFrame {
  FrameByFrame(const body::BodyModel& model, const JointModel& tracker, const Subject& subject,
               const CaptureOptions& options)
      : k(hal::rotate_upright(options.intrinsics, options.scene.rotate_deg)),
        sensor(k.width, k.height, tracker),
        fuser(k.width, k.height) {
    VirtualScene scene(model, subject, options.scene, options.sensor, options.intrinsics, options.seed);
    const auto size = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
    std::vector<std::uint16_t> delivered(size), upright(size);
    std::vector<std::uint8_t> mask(size);
    const DepthImage in(delivered.data(), options.intrinsics.width, options.intrinsics.height);
    const DepthImage out(upright.data(), k.width, k.height);
    for (int i = 0; i < 4 * options.frame_count && fuser.frame_count() < options.frame_count; ++i) {
      scene.render(static_cast<std::uint64_t>(i), in);
      hal::rotate_upright(in, options.scene.rotate_deg, out);
      const Detection detection = sensor.sense(out, k, {mask.data(), k.width, k.height});
      if (detection.guidance == 0) fuser.add(out, {mask.data(), k.width, k.height}, k, detection);
    }
  }

  Intrinsics k;
  PersonDetector sensor;
  Fuser fuser;
};

class Captures : public WithTracker {};

// The median sensed once in place of each frame: the same outline, the same depth, the same joints, but for
// what noise does to either.
TEST_F(Captures, FuseToWhatTheDeviceFuses) {
  CaptureRig rig(model(), tracker());
  int compared = 0;
  double area_change = 0;
  for (std::uint64_t who = 0; who < 12; ++who) {
    const Subject subject = draw_subject(model(), Family::training, 321, who);
    CaptureOptions options = draw_capture({}, 321, who, 0);
    options.frame_count = 9;
    const Capture& capture = rig.run(subject, options);
    FrameByFrame device(model(), tracker(), subject, options);
    if (!capture.valid || device.fuser.frame_count() < options.frame_count) continue;
    ++compared;
    const Fuser::Description& expected = device.fuser.describe();
    EXPECT_EQ(capture.frame_count, 9);
    EXPECT_NEAR(capture.distance_mm, expected.distance_mm, 25) << who;
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_LT(norm(capture.joints.position_mm[j] - expected.joints.position_mm[j]), 60) << who << " joint " << j;

    const MaskView ours = rig.fused()->mask(), theirs = device.fuser.mask();
    const auto depth = rig.fused()->depth_q4(), its = device.fuser.depth_q4();
    int both = 0, either = 0, area = 0, its_area = 0;
    double off = 0;
    for (int v = 0; v < ours.height; ++v)
      for (int u = 0; u < ours.width; ++u) {
        const bool a = ours.at(u, v) != 0, b = theirs.at(u, v) != 0;
        area += a ? 1 : 0;
        its_area += b ? 1 : 0;
        either += a || b ? 1 : 0;
        if (!a || !b) continue;
        ++both;
        off += std::abs(depth.at(u, v) - its.at(u, v)) / 16.0;
      }
    EXPECT_GT(both, 0.985 * either) << who;
    EXPECT_LT(off / both, 0.5) << who << ": the same nine frames are behind both";
    area_change += static_cast<double>(area) / its_area - 1;
  }
  ASSERT_GE(compared, 8);
  // Outlines come out neither wider nor narrower.
  EXPECT_LT(std::abs(area_change / compared), 0.004);
  RecordProperty("area_change_ppm", static_cast<int>(1e6 * area_change / compared));
}

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
