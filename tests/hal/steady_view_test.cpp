// SPDX-License-Identifier: Apache-2.0
// Frames of a camera that moves and reports its pose, against the frames of a camera at rest in the same scene.
#include "hal/steady_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "hal/source.h"

namespace im2fit::hal {
namespace {

constexpr Intrinsics kCamera{240, 320, 288, 288, 119.5F, 159.5F};

CameraPose turned_about(Vec3f axis, double degrees, Vec3f position_mm = {}) {
  const Vec3f unit = normalized(axis);
  const double half = degrees * std::numbers::pi / 360;
  const auto s = static_cast<float>(std::sin(half));
  return {unit.x * s, unit.y * s, unit.z * s, static_cast<float>(std::cos(half)), position_mm};
}

// v by the quaternion, in another way than SteadyView: v + 2 q x (q x v + w v).
Vec3f rotated(const CameraPose& q, Vec3f v) {
  const Vec3f axis = {q.x, q.y, q.z};
  return v + cross(axis, cross(axis, v) + v * q.w) * 2;
}

// A wall three metres away, a ball as wide as a chest two metres away, a hole in the wall without data.
std::vector<std::uint16_t> seen_from(const CameraPose& pose) {
  constexpr float kWallMm = 3000, kRadiusMm = 250;
  constexpr Vec3f kBall{60, -80, 2000};
  std::vector<std::uint16_t> depth;
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      const Vec3f ray = rotated(pose, {(static_cast<float>(u) - kCamera.cx) / kCamera.fx,
                                       (static_cast<float>(v) - kCamera.cy) / kCamera.fy, 1});
      const Vec3f to_ball = kBall - pose.position_mm;
      const float along = dot(ray, to_ball) / dot(ray, ray);
      const Vec3f off = ray * along - to_ball;
      const float inside = kRadiusMm * kRadiusMm - dot(off, off);
      float mm = (kWallMm - pose.position_mm.z) / ray.z;
      const Vec3f on_wall = pose.position_mm + ray * mm;
      if (on_wall.x > 500 && on_wall.y > 500) mm = 0;
      if (inside > 0) mm = along - std::sqrt(inside / dot(ray, ray));
      depth.push_back(static_cast<std::uint16_t>(mm + 0.5F));
    }
  return depth;
}

struct Difference {
  double within_3mm = 0;  // of pixels that both have
  double lost = 0;        // of pixels that the camera at rest has
  double mean_mm = 0;     // of those within 100 mm
};

Difference difference(const std::vector<std::uint16_t>& found, const std::vector<std::uint16_t>& expected) {
  int both = 0, close = 0, near = 0, had = 0;
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    had += expected[i] != 0 ? 1 : 0;
    if (expected[i] == 0 || found[i] == 0) continue;
    ++both;
    const int off = found[i] - expected[i];
    close += std::abs(off) <= 3 ? 1 : 0;
    if (std::abs(off) > 100) continue;
    sum += off;
    ++near;
  }
  return {static_cast<double>(close) / both, 1 - static_cast<double>(both) / had, sum / near};
}

std::vector<std::uint16_t> steadied(SteadyView& view, const CameraPose& pose) {
  auto frame = seen_from(pose);
  if (view.take(pose)) view.run(kCamera, {frame.data(), kCamera.width, kCamera.height});
  return frame;
}

class SteadyViewTest : public testing::Test {
 protected:
  void SetUp() override {
    view_.prepare(kCamera.width, kCamera.height);
    EXPECT_FALSE(view_.take(rest_));
  }
  // Any place at rest will do: the first pose is not the identity.
  CameraPose rest_ = turned_about({1, 2, -1}, 40, {500, -200, 900});
  // `pose` of the camera in the axes of the view.
  CameraPose from_rest(const CameraPose& pose) const {
    const Vec3f a = {rest_.x, rest_.y, rest_.z}, b = {pose.x, pose.y, pose.z};
    const Vec3f axis = b * rest_.w + a * pose.w + cross(a, b);
    return {axis.x, axis.y, axis.z, rest_.w * pose.w - dot(a, b),
            rest_.position_mm + rotated(rest_, pose.position_mm)};
  }
  // What the view makes of a frame taken at `pose`.
  std::vector<std::uint16_t> shown(const CameraPose& pose) {
    auto frame = seen_from(pose);
    if (view_.take(from_rest(pose))) view_.run(kCamera, {frame.data(), kCamera.width, kCamera.height});
    return frame;
  }
  SteadyView view_;
};

TEST_F(SteadyViewTest, ACameraAtRestIsLeftAlone) {
  EXPECT_FALSE(view_.take(rest_));
  SteadyView unmoved;
  unmoved.prepare(kCamera.width, kCamera.height);
  EXPECT_EQ(steadied(unmoved, {}), seen_from({}));
}

// What a turn of three degrees takes at the picture's edge: at 22.6 degrees aside 18 of 240 columns, and a little
// above and below.
constexpr double kLostMax = 0.09;

TEST_F(SteadyViewTest, ATurnIsUndone) {
  const auto expected = seen_from({});
  for (const Vec3f axis : {Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}, Vec3f{1, -2, 3}}) {
    SCOPED_TRACE(testing::Message() << axis.x << " " << axis.y << " " << axis.z);
    const Difference d = difference(shown(turned_about(axis, 3)), expected);
    const Difference as_it_is = difference(seen_from(turned_about(axis, 3)), expected);
    EXPECT_GT(d.within_3mm, 0.96);
    EXPECT_LT(d.lost, kLostMax);
    EXPECT_NEAR(d.mean_mm, 0, 0.3);
    // A wall that stands across hardly changes about the camera's own axis.
    EXPECT_GT(d.within_3mm, as_it_is.within_3mm + (axis.x != 0 || axis.y != 0 ? 0.03 : 0.01));
  }
}

TEST_F(SteadyViewTest, AStepIsUndone) {
  const auto expected = seen_from({});
  for (const Vec3f step : {Vec3f{40, 0, 0}, Vec3f{0, -40, 0}, Vec3f{0, 0, 40}, Vec3f{-25, 25, -25}}) {
    const Difference d = difference(shown(turned_about({1, -2, 3}, 2, step)), expected);
    EXPECT_GT(d.within_3mm, 0.94) << step.x << " " << step.y << " " << step.z;
    EXPECT_LT(d.lost, kLostMax) << step.x << " " << step.y << " " << step.z;
    EXPECT_NEAR(d.mean_mm, 0, 0.5) << step.x << " " << step.y << " " << step.z;
  }
}

TEST_F(SteadyViewTest, WhereItLooksElsewhereTheViewIsAnother) {
  const CameraPose away = turned_about({0, 1, 0}, 12);
  EXPECT_EQ(shown(away), seen_from(away));
  EXPECT_FALSE(view_.take(from_rest(away)));
  EXPECT_TRUE(view_.take(from_rest(turned_about({0, 1, 0}, 9))));
  const CameraPose far_off = turned_about({0, 1, 0}, 12, {0, 200, 0});
  EXPECT_EQ(shown(far_off), seen_from(far_off));
  view_.forget();
  EXPECT_FALSE(view_.take(from_rest(turned_about({0, 1, 0}, 9))));
}

TEST_F(SteadyViewTest, AnOppositeQuaternionIsTheSameTurn) {
  const CameraPose pose = from_rest(turned_about({1, 1, 0}, 4));
  ASSERT_TRUE(view_.take(pose));
  const Vec3f down = view_.in_view({0.1F, 0.9F, 0.2F});
  ASSERT_TRUE(view_.take({-pose.x, -pose.y, -pose.z, -pose.w, pose.position_mm}));
  const Vec3f again = view_.in_view({0.1F, 0.9F, 0.2F});
  EXPECT_NEAR(down.x, again.x, 1e-6F);
  EXPECT_NEAR(down.y, again.y, 1e-6F);
  EXPECT_NEAR(down.z, again.z, 1e-6F);
}

// Of a camera that is carried at half a metre a second each frame is a view of its own; in the hand of somebody who
// stands it is steadied again, although its told place trembles by some mm.
TEST_F(SteadyViewTest, AWalkingCameraIsLeftAloneWhereWalksAreFollowed) {
  constexpr float kFrameS = 1.0F / 30;
  const auto at = [&](float x_mm, int i) {
    CameraPose pose = rest_;
    pose.position_mm = rest_.position_mm + Vec3f{x_mm + (i % 2 == 0 ? 3.0F : -3.0F), 0, 0};
    return pose;
  };
  for (const bool follows : {false, true}) {
    view_.forget();
    view_.follow_walks(follows);
    static_cast<void>(view_.take(at(0, 0), kFrameS));
    int changed_standing = 0, changed_walking = 0, changed_after = 0;
    for (int i = 1; i < 60; ++i) changed_standing += view_.take(at(0, i), kFrameS) ? 1 : 0;
    for (int i = 0; i < 60; ++i)
      changed_walking += view_.take(at(500 * kFrameS * static_cast<float>(i), i), kFrameS) && i >= 10 ? 1 : 0;
    for (int i = 0; i < 60; ++i) changed_after += view_.take(at(1000, i), kFrameS) && i >= 30 ? 1 : 0;
    EXPECT_GE(changed_standing, 28);
    EXPECT_GE(changed_after, 14);
    if (follows)
      EXPECT_EQ(changed_walking, 0);
    else
      EXPECT_GE(changed_walking, 35);
  }
}

// Gravity given in a turned camera's axes is the view's.
TEST_F(SteadyViewTest, ADirectionIsTurnedAlong) {
  const CameraPose pose = turned_about({3, 1, 2}, 7);
  ASSERT_TRUE(view_.take(from_rest(pose)));
  const Vec3f seen = rotated({-pose.x, -pose.y, -pose.z, pose.w, {}}, {0, 1, 0});
  const Vec3f down = view_.in_view(seen);
  EXPECT_NEAR(down.x, 0, 1e-5F);
  EXPECT_NEAR(down.y, 1, 1e-5F);
  EXPECT_NEAR(down.z, 0, 1e-5F);
}

// A picture turned upright and then steadied is the steadied picture turned upright.
TEST(SteadyViewUpright, PosesTurnWithThePicture) {
  for (const int degrees : {90, 180, 270}) {
    const CameraPose poses[] = {turned_about({1, 0, 1}, 5, {10, 0, 0}), turned_about({0, 2, 1}, 6, {0, 20, -10})};
    SteadyView delivered, upright;
    delivered.prepare(kCamera.width, kCamera.height);
    const Intrinsics k = rotate_upright(kCamera, degrees);
    upright.prepare(k.width, k.height);
    static_cast<void>(delivered.take(poses[0]));
    static_cast<void>(upright.take(rotate_upright(poses[0], degrees)));
    auto frame = seen_from({});
    std::vector<std::uint16_t> turned(frame.size()), expected(frame.size());
    rotate_upright({frame.data(), kCamera.width, kCamera.height}, degrees, {turned.data(), k.width, k.height});
    ASSERT_TRUE(delivered.take(poses[1]));
    ASSERT_TRUE(upright.take(rotate_upright(poses[1], degrees)));
    delivered.run(kCamera, {frame.data(), kCamera.width, kCamera.height});
    upright.run(k, {turned.data(), k.width, k.height});
    rotate_upright({frame.data(), kCamera.width, kCamera.height}, degrees, {expected.data(), k.width, k.height});
    std::size_t same = 0;
    for (std::size_t i = 0; i < turned.size(); ++i) same += std::abs(turned[i] - expected[i]) <= 1 ? 1 : 0;
    EXPECT_GT(static_cast<double>(same) / static_cast<double>(turned.size()), 0.999) << degrees;
  }
}

}  // namespace
}  // namespace im2fit::hal
