// SPDX-License-Identifier: Apache-2.0
// Animals and mirrors against closed forms, and the tracker's results in the scenes with them.
#include "evaluation/tracker/scene_props.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "evaluation/tracker/guidance_scenes.h"
#include "evaluation/tracker/guidance_trials.h"
#include "person/data_files.h"
#include "tests/train/body_fixture.h"
#include "train/camera/virtual_camera.h"

namespace im2fit::lab {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr float kDistanceMm = 2500, kCameraHeightMm = 1000;
constexpr std::uint16_t kBehindMm = 4000;

const Intrinsics kLens = kinect_intrinsics(kWidth, kHeight);
const FloorPlane kLevel{true, {0, -1, 0}, kCameraHeightMm};

struct Picture {
  std::vector<std::uint16_t> mm = std::vector<std::uint16_t>(kWidth * kHeight, kBehindMm);
  DepthImage image() { return {mm.data(), kWidth, kHeight}; }
  std::uint16_t at(int u, int v) const { return mm[static_cast<std::size_t>(v * kWidth + u)]; }
};

Picture drawn(const Props& props, std::uint64_t frame, Picture before = {}) {
  draw_props(props, PropAxes(kLevel, kDistanceMm), kLens, 7, frame, before.image());
  return before;
}

struct Box {
  int u_min = kWidth, u_max = -1, v_min = kHeight, v_max = -1, near = 65535, far = 0;
};
Box changed(const Picture& picture) {
  Box box;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const int z = picture.at(u, v);
      if (z == kBehindMm) continue;
      box = {std::min(box.u_min, u), std::max(box.u_max, u), std::min(box.v_min, v),
             std::max(box.v_max, v), std::min(box.near, z),  std::max(box.far, z)};
    }
  return box;
}
float u_of(float x, float z) {
  return kLens.fx * x / z + kLens.cx;
}
float v_of(float height, float z) {
  return kLens.fy * (kCameraHeightMm - height) / z + kLens.cy;
}

// Across the picture and 600 mm to the right: snout and tail, soles and the top of the head.
TEST(SceneProps, AnAnimalStandsWhereItIsPut) {
  Props props;
  props.animal = make_animal(570, 0);
  props.animal->place = {600, 0, 0};
  const Box box = changed(drawn(props, 0));
  EXPECT_NEAR(static_cast<float>(box.u_min), u_of(600 - 585, kDistanceMm), 2);
  EXPECT_NEAR(static_cast<float>(box.u_max), u_of(600 + 625, kDistanceMm), 2);
  EXPECT_NEAR(static_cast<float>(box.v_min), v_of(730, kDistanceMm), 2);
  EXPECT_NEAR(static_cast<float>(box.v_max), v_of(0, kDistanceMm - 75), 2);
  EXPECT_NEAR(box.near, kDistanceMm - 120, 40);
  EXPECT_LT(box.far, kDistanceMm + 120 + 40);
}

TEST(SceneProps, AnAnimalWalksAndIsBehindWhatIsNearer) {
  Props props;
  props.animal = make_animal(300, 90);
  props.animal->place = {-500, 0, 0};
  props.animal->step = {20, 0, 0};
  const Box first = changed(drawn(props, 0)), later = changed(drawn(props, 25));
  EXPECT_NEAR(static_cast<float>(later.u_min - first.u_min),
              u_of(500, kDistanceMm - 100) - u_of(0, kDistanceMm - 100), 3)
      << "of its near end";
  Picture near;
  std::fill(near.mm.begin(), near.mm.end(), std::uint16_t{1500});
  std::fill_n(near.mm.begin(), kWidth * kHeight / 2, std::uint16_t{0});
  EXPECT_EQ(drawn(props, 0, near).mm, near.mm) << "what is nearer, and where no data are";
  EXPECT_EQ(drawn(props, 3).mm, drawn(props, 3).mm);
}

// Square behind the person: the wall is one depth, the mirror a rectangle through which the room behind is seen.
TEST(SceneProps, AMirrorIsAWindowInItsWall) {
  Props props;
  props.mirror = MirrorWall{{0, 0, -1}, 800, 500, 200, 1900};
  const Picture picture = drawn(props, 0);
  const float wall = kDistanceMm + 800;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const float x = (static_cast<float>(u) - kLens.cx) / kLens.fx * wall;
      const float y = kCameraHeightMm - (static_cast<float>(v) - kLens.cy) / kLens.fy * wall;
      const float edge = std::min({std::fabs(std::fabs(x) - 500), std::fabs(y - 200), std::fabs(y - 1900)});
      if (edge < 10) continue;
      const bool seen = std::fabs(x) < 500 && y > 200 && y < 1900;
      ASSERT_NEAR(picture.at(u, v), seen ? kBehindMm : wall, seen ? 0 : 90) << u << ' ' << v;
    }
}

TEST(SceneProps, ATurnedMirrorIsNearerOnOneSide) {
  Props props;
  props.mirror = MirrorWall{{0.5F, 0, -std::sqrt(0.75F)}, 800, 0, 0, 0};
  const Picture picture = drawn(props, 0);
  const float s = 0.5F, c = std::sqrt(0.75F);
  // On the ray of column u: x s + (z - 2500) c = 800.
  for (const int u : {40, 160, 280}) {
    const float slope = (static_cast<float>(u) - kLens.cx) / kLens.fx;
    const float z = (800 + kDistanceMm * c) / (slope * s + c);
    EXPECT_NEAR(picture.at(u, 120), std::min<float>(z, kBehindMm), 90) << u;
  }
}

class ReportedScenes : public WithBody {};

TEST_F(ReportedScenes, AnimalsWallsAndMirrorsDisturbNothing) {
  const std::string path = data_path("IM2FIT_TRACKER", "tracker.i2t");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no tracker at " << path;
  const auto tracker = Tracker::load(path);
  ASSERT_TRUE(tracker) << tracker.error().message;
  GuidanceOptions options;
  options.scenes = 2;
  options.kinds = {"PET", "PET_ALONE", "WALL", "MIRROR", "LEGS_ALONE"};
  options.seed = 36;
  const auto outcomes = run_guidance(model(), tracker->model(), options);
  ASSERT_TRUE(outcomes) << outcomes.error().message;
  ASSERT_EQ(outcomes->size(), 10U);
  for (const GuidanceOutcome& outcome : *outcomes) {
    if (outcome.kind == "LEGS_ALONE")
      EXPECT_NE(outcome.raised, 0U) << "legs are not measured";
    else
      EXPECT_TRUE(outcome.right()) << outcome.kind << ' ' << outcome.scene << " raised " << outcome.raised;
  }
}

}  // namespace
}  // namespace im2fit::lab
