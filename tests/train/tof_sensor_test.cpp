// SPDX-License-Identifier: Apache-2.0
// Time of flight against the header's figures.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "train/camera/depth_sensor.h"
#include "train/camera/virtual_camera.h"

namespace im2fit::lab {
namespace {

CleanView room(const Intrinsics& k, std::span<const Plane> planes) {
  CleanView view(k.width, k.height);
  draw_room(planes, k, whole(k.width, k.height), view);
  return view;
}

std::vector<std::uint16_t> expose(DepthSensor& sensor, const CleanView& view, std::uint64_t frame) {
  std::vector<std::uint16_t> pixels(view.label.size());
  sensor.expose(view, whole(view.width, view.height), 5, frame, DepthImage(pixels.data(), view.width, view.height),
                nullptr);
  return pixels;
}

struct Spread {
  double mean = 0, sd = 0;
  int count = 0;
};
Spread error_of(const CleanView& view, const SensorOptions& options, const Intrinsics& k) {
  DepthSensor sensor(options, k);
  sensor.prepare(view, whole(k.width, k.height));
  double sum = 0, square = 0;
  Spread out;
  for (std::uint64_t frame = 0; frame < 6; ++frame) {
    const auto pixels = expose(sensor, view, frame);
    for (int v = k.height / 2 - 30; v < k.height / 2 + 30; ++v) {
      for (int u = k.width / 2 - 30; u < k.width / 2 + 30; ++u) {
        const std::size_t at = view.at(u, v);
        if (pixels[at] == 0) continue;
        const double error = pixels[at] - 1.0 / static_cast<double>(view.inverse_depth[at]);
        sum += error;
        square += error * error;
        ++out.count;
      }
    }
  }
  out.mean = sum / out.count;
  out.sd = std::sqrt(square / out.count - out.mean * out.mean);
  return out;
}

TEST(TofSensor, SpreadFollowsTheStatedFormula) {
  for (const int width : {640, 320}) {
    const Intrinsics k = kinect_intrinsics(width, width * 3 / 4);
    for (const double z : {600.0, 1000.0, 2000.0, 3000.0, 4000.0}) {
      const std::array<Plane, 1> wall = {Plane{{0, 0, 1}, static_cast<float>(z)}};
      const CleanView view = room(k, wall);
      const Spread s = error_of(view, tof_sensor(), k);
      const double metres = z / 1000;
      const double stated = std::hypot(2.0 + 0.3 * metres * metres, std::sqrt(1.0 / 12));  // whole millimetres
      EXPECT_NEAR(s.sd, stated, 0.06 * stated) << z;
      EXPECT_NEAR(s.mean, 0, 0.3) << z;
    }
  }
}

TEST(TofSensor, GrazingSurfacesAreNoisier) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const double t = 60 * std::numbers::pi / 180;
  const Vec3f normal{static_cast<float>(std::sin(t)), 0, static_cast<float>(std::cos(t))};
  const std::array<Plane, 1> wall = {Plane{normal, 2000 * normal.z}};
  const Spread s = error_of(room(k, wall), tof_sensor(), k);
  const double rest = std::numbers::pi / 2 - t;
  const double stated = 2.0 + 0.3 * 4 + 0.1 * std::pow(2, 1.5) * t * t / (rest * rest);
  EXPECT_NEAR(s.sd, stated, 0.12 * stated);  // incidence and distance vary over the patch
}

TEST(TofSensor, HasNoDisparitySteps) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const std::array<Plane, 1> wall = {Plane{{0, 0, 1}, 3000}};
  const CleanView view = room(k, wall);
  DepthSensor sensor(tof_sensor(), k);
  sensor.prepare(view, whole(k.width, k.height));
  std::vector<bool> seen(20);
  for (const std::uint16_t z : expose(sensor, view, 0))
    if (z >= 2990 && z < 3010) seen[z - 2990U] = true;
  for (std::size_t i = 5; i < 15; ++i) EXPECT_TRUE(seen[i]) << i;  // Kinect's step is 26 mm there
}

TEST(TofSensor, RangeIsFortyCentimetresToFiveMetres) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  for (const auto& [z, there] : {std::pair{350.0F, false}, {430.0F, true}, {4900.0F, true}, {5100.0F, false}}) {
    const std::array<Plane, 1> wall = {Plane{{0, 0, 1}, z}};
    const CleanView view = room(k, wall);
    DepthSensor sensor(tof_sensor(), k);
    sensor.prepare(view, whole(k.width, k.height));
    int delivered = 0;
    for (const std::uint16_t p : expose(sensor, view, 0)) delivered += p != 0 ? 1 : 0;
    if (there) {
      EXPECT_GT(delivered, 320 * 240 * 0.85) << z;
    } else {
      EXPECT_LT(delivered, 320 * 240 * 0.02) << z;
    }
  }
}

// A near square before a far wall: every pixel away from its border is near or far, beside it some lie between, none
// lies outside, and some are given up.
TEST(TofSensor, FlyingPixelsLieBetweenBothSurfaces) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const std::array<Plane, 1> wall = {Plane{{0, 0, 1}, 3000}};
  CleanView view = room(k, wall);
  for (int v = 80; v < 160; ++v) {
    for (int u = 100; u < 200; ++u) {
      view.inverse_depth[view.at(u, v)] = 1 / 1500.0F;
      view.label[view.at(u, v)] = kPerson;
    }
  }
  DepthSensor sensor(tof_sensor(), k);
  sensor.prepare(view, whole(k.width, k.height));
  int beside = 0, between = 0, lost = 0;
  for (std::uint64_t frame = 0; frame < 5; ++frame) {
    const auto pixels = expose(sensor, view, frame);
    for (int v = 90; v < 150; ++v) {
      for (int u = 70; u < 130; ++u) {
        const double z = pixels[view.at(u, v)];
        const bool at_border = u == 99 || u == 100;
        const double own = u < 100 ? 3000 : 1500;
        ASSERT_TRUE(at_border || z == 0 || std::fabs(z - own) < 30) << u;
        if (!at_border) continue;
        ++beside;
        lost += z == 0 ? 1 : 0;
        if (z == 0) continue;
        ASSERT_GT(z, 1480);
        ASSERT_LT(z, 3030);
        between += z > 1530 && z < 2970 ? 1 : 0;
      }
    }
  }
  EXPECT_NEAR(static_cast<double>(between) / beside, 0.45 * (1 - 30 / 750.0), 0.07);
  EXPECT_NEAR(static_cast<double>(lost) / beside, 0.15, 0.05);
}

// Two walls that meet at right angles ahead: too far in the corner, by 20 mm at most, and right away from it.
TEST(TofSensor, MultipathLengthensCorners) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const float s = std::sqrt(0.5F);
  const std::array<Plane, 2> walls = {Plane{{s, 0, s}, 2500 * s}, Plane{{-s, 0, s}, 2500 * s}};
  const CleanView view = room(k, walls);
  DepthSensor sensor(tof_sensor(), k);
  sensor.prepare(view, whole(k.width, k.height));
  std::array<double, 3> sum{};  // in the corner, 20 px beside, 60 px beside
  std::array<int, 3> count{};
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    const auto pixels = expose(sensor, view, frame);
    for (int v = 30; v < 210; ++v) {
      for (const auto& [u, at] : {std::pair{159, 0U}, {160, 0U}, {180, 1U}, {220, 2U}}) {
        const std::size_t p = view.at(u, v);
        if (pixels[p] == 0) continue;
        sum[at] += pixels[p] - 1.0 / static_cast<double>(view.inverse_depth[p]);
        ++count[at];
      }
    }
  }
  EXPECT_GT(sum[0] / count[0], 8);
  EXPECT_LT(sum[0] / count[0], 20.5);
  EXPECT_NEAR(sum[1] / count[1], 0, 1);
  EXPECT_NEAR(sum[2] / count[2], 0, 1);
}

TEST(TofSensor, SameSeedSamePicture) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const std::array<Plane, 1> wall = {Plane{{0, 0, 1}, 2000}};
  const CleanView view = room(k, wall);
  DepthSensor a(tof_sensor(), k), b(tof_sensor(), k);
  a.prepare(view, whole(k.width, k.height));
  b.prepare(view, whole(k.width, k.height));
  (void)expose(b, view, 1);
  EXPECT_EQ(expose(a, view, 7), expose(b, view, 7));
  EXPECT_NE(expose(a, view, 7), expose(a, view, 8));
}

}  // namespace
}  // namespace im2fit::lab
