// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_scenes.h"

#include <cmath>
#include <vector>

#include "body_fixture.h"
#include "hal/source.h"

namespace im2fit::lab {
namespace {

constexpr int kDraws = 3000;

TrackerScene drawn(const TrackerMix& mix, std::uint64_t i) {
  Rng rng = Rng::for_item(3, 4, i);
  return draw_tracker_scene(mix, rng);
}

TEST(TrackerScenes, SharesAreTheMixtures) {
  const TrackerMix mix = training_mix();
  std::array<double, kPoseClassCount> classes{};
  double clothed = 0, hair = 0, back = 0, furnished = 0, others = 0, tof = 0, vga = 0, portrait = 0, seated = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const TrackerScene t = drawn(mix, i);
    classes[static_cast<std::size_t>(t.pose_class)] += 1;
    clothed += t.clothing != Clothing::none ? 1 : 0;
    hair += t.scene.hair ? 1 : 0;
    back += t.back_view ? 1 : 0;
    seated += t.pose_class == PoseClass::seated ? 1 : 0;
    furnished += t.furnished ? 1 : 0;
    others += t.others > 0 ? 1 : 0;
    tof += t.kind == SensorKind::time_of_flight ? 1 : 0;
    vga += t.intrinsics.width == 640 ? 1 : 0;
    portrait += t.rotate_deg % 180 == 90 ? 1 : 0;
    EXPECT_EQ(t.clothing, t.scene.clothing);
    EXPECT_EQ(t.back_view, t.scene.back_view);
    EXPECT_EQ(t.kind, t.sensor.kind);
    EXPECT_EQ(t.rotate_deg, t.scene.rotate_deg);
    EXPECT_FALSE(t.back_view && t.pose_class == PoseClass::seated);
    EXPECT_EQ(t.pose_class == PoseClass::seated, t.scene.pose == StandingPose::seated);
    EXPECT_EQ(t.pose_class == PoseClass::crossed, t.scene.pose == StandingPose::crossed);
    EXPECT_EQ(t.pose_class == PoseClass::bowed, t.scene.pose == StandingPose::bowed);
    if (t.pose_class == PoseClass::turned) {
      EXPECT_GE(std::fabs(t.scene.yaw_deg), 20);
      EXPECT_LE(std::fabs(t.scene.yaw_deg), mix.turned_max_deg);
    }
  }
  double weights = 0;
  for (const double w : mix.pose_weight) weights += w;
  for (std::size_t c = 0; c < kPoseClassCount; ++c)
    EXPECT_NEAR(classes[c] / kDraws, mix.pose_weight[c] / weights, 0.03) << kPoseClassNames[c];
  EXPECT_NEAR(clothed / kDraws, mix.clothed_share, 0.03);
  EXPECT_NEAR(hair / kDraws, mix.hair_share, 0.03);
  EXPECT_NEAR(back / (kDraws - seated), mix.back_share, 0.03);
  EXPECT_NEAR(furnished / kDraws, mix.furniture_share, 0.03);
  EXPECT_NEAR(others / kDraws, mix.others_share, 0.03);
  EXPECT_NEAR(tof / kDraws, mix.tof_share, 0.03);
  EXPECT_NEAR(vga / kDraws, mix.vga_share, 0.03);
  EXPECT_NEAR(portrait / kDraws, mix.portrait_share, 0.03);
}

TEST(TrackerScenes, BareIsBare) {
  for (std::uint64_t i = 0; i < 400; ++i) {
    const TrackerScene t = drawn(bare_mix(), i);
    EXPECT_EQ(t.clothing, Clothing::none);
    EXPECT_FALSE(t.scene.hair || t.furnished || t.back_view);
    EXPECT_EQ(t.others + t.scene.furniture_count + t.scene.decoy_count, 0);
    EXPECT_TRUE(t.pose_class == PoseClass::calm || t.pose_class == PoseClass::psi || t.pose_class == PoseClass::free);
    EXPECT_EQ(t.kind, SensorKind::structured_light);
  }
}

class TrackerScenesStaged : public WithBody {};

TEST_F(TrackerScenesStaged, FullConditionsShowWholePeopleAtUsualDistances) {
  std::unique_ptr<VirtualScene> scene;
  for (std::uint64_t i = 0; i < 60; ++i) {
    TrackerScene t = drawn(full_conditions_mix(), i);
    const Subject subject = draw_subject(model(), Family::held_out, 40, i % 10);
    VirtualScene staged(model(), subject, t.scene, t.sensor, t.intrinsics, t.seed);
    t.place(staged);
    EXPECT_TRUE(t.whole) << i;
    EXPECT_GE(t.distance_mm, 2000);
    EXPECT_LE(t.distance_mm, 4650);
    EXPECT_NE(t.clothing, Clothing::none);
    EXPECT_GE(t.camera_height_mm, 800);
    EXPECT_LE(t.camera_height_mm, 1200);
  }
}

// Camera within the stated ranges; `whole` against the joints' own pixels.
TEST_F(TrackerScenesStaged, TrainingCamerasStayInTheirRanges) {
  int cut = 0, low = 0, high = 0, near = 0;
  for (std::uint64_t i = 0; i < 150; ++i) {
    TrackerMix mix = training_mix();
    mix.others_share = 0;
    mix.cut_share = 0.3;
    mix.wide_share = 1;
    TrackerScene t = drawn(mix, i);
    const Subject subject = draw_subject(model(), Family::training, 40, i % 10);
    VirtualScene staged(model(), subject, t.scene, t.sensor, t.intrinsics, t.seed);
    t.place(staged);
    EXPECT_GE(t.camera_height_mm, 500);
    EXPECT_LE(t.camera_height_mm, 2200);
    EXPECT_GE(t.distance_mm, 1000);
    EXPECT_LE(t.distance_mm, 4650);
    const FloorPlane floor = staged.floor();
    EXPECT_LT(std::fabs(std::asin(floor.up.z)) * 57.29578F, 20.1F);  // the optical axis against the level
    const Intrinsics k = hal::rotate_upright(t.intrinsics, t.rotate_deg);
    const JointSet joints = staged.joints(0);
    bool all = true;
    for (const Vec3f& p : joints.position_mm)
      all = all &&
            std::fabs(p.x * k.fx / p.z + k.cx - static_cast<float>(k.width - 1) / 2) <=
                static_cast<float>(k.width - 1) / 2 &&
            std::fabs(p.y * k.fy / p.z + k.cy - static_cast<float>(k.height - 1) / 2) <=
                static_cast<float>(k.height - 1) / 2;
    EXPECT_EQ(t.whole, all) << i;
    cut += t.whole ? 0 : 1;
    low += t.camera_height_mm < 800 ? 1 : 0;
    high += t.camera_height_mm > 1800 ? 1 : 0;
    near += t.distance_mm < 1700 ? 1 : 0;
  }
  EXPECT_GT(cut, 15);
  EXPECT_GT(low, 10);
  EXPECT_GT(high, 10);
  EXPECT_GT(near, 10);
}

TEST_F(TrackerScenesStaged, ASceneDrawnTwiceIsTheSame) {
  const Subject subject = draw_subject(model(), Family::training, 40, 1);
  std::unique_ptr<VirtualScene> reused;
  for (std::uint64_t i = 0; i < 12; ++i) {
    TrackerMix mix = training_mix();
    mix.vga_share = mix.tof_share = 0;
    mix.others_share = 0.5;
    const TrackerScene a = drawn(mix, i), b = drawn(mix, i);
    ASSERT_EQ(a.seed, b.seed);
    ASSERT_TRUE(a.sensor == b.sensor);
    ASSERT_EQ(a.intrinsics.width, b.intrinsics.width);
    ASSERT_EQ(a.intrinsics.height, b.intrinsics.height);
    VirtualScene fresh(model(), subject, a.scene, a.sensor, a.intrinsics, a.seed);
    if (reused == nullptr)
      reused = std::make_unique<VirtualScene>(model(), subject, b.scene, b.sensor, b.intrinsics, b.seed);
    else
      reused->restage(subject, b.scene, b.seed);
    std::vector<std::uint16_t> x(320 * 240), y(320 * 240);
    fresh.render(0, DepthImage(x.data(), 320, 240));
    reused->render(0, DepthImage(y.data(), 320, 240));
    EXPECT_EQ(x, y) << i;
  }
}

}  // namespace
}  // namespace im2fit::lab
