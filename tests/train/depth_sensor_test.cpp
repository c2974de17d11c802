// SPDX-License-Identifier: Apache-2.0
// The sensor against the published figures: Nguyen 2012 (spread), Khoshelham 2012 (steps), geometry (shadow).
#include "train/camera/depth_sensor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "core/rng.h"
#include "train/camera/virtual_camera.h"
#include "train/render/raw_row.h"

namespace im2fit::lab {
namespace {

constexpr int kWidth = 320, kHeight = 240;

CleanView wall_at(double z_mm, const Intrinsics& k, Vec3f normal = {0, 0, 1}) {
  CleanView view(k.width, k.height);
  const std::array<Plane, 1> planes = {Plane{normal, static_cast<float>(z_mm * static_cast<double>(normal.z))}};
  draw_room(planes, k, whole(k.width, k.height), view);
  return view;
}

struct Frames {
  const CleanView& view;
  DepthSensor sensor;
  std::vector<std::uint16_t> pixels;
  Frames(const CleanView& v, const SensorOptions& options, const Intrinsics& k)
      : view(v), sensor(options, k), pixels(v.label.size()) {
    sensor.prepare(view, whole(view.width, view.height));
  }
  const std::vector<std::uint16_t>& take(std::uint64_t frame, std::uint64_t seed = 5) {
    sensor.expose(view, whole(view.width, view.height), seed, frame,
                  DepthImage(pixels.data(), view.width, view.height), nullptr);
    return pixels;
  }
};

SensorOptions noise_only(bool quantise) {
  SensorOptions o;
  o.quantise = quantise;
  o.shadow = o.holes = false;
  return o;
}

TEST(DepthSensor, SpreadIsNguyensAlsoAfterQuantisation) {
  const Intrinsics k = kinect_intrinsics(kWidth, kHeight);
  for (const bool quantise : {false, true}) {
    for (const double z : {1000.0, 2000.0, 3000.0}) {
      // A tilted wall runs through many quantiser steps; 8 degrees leave the grazing term below a thousandth.
      const CleanView view = wall_at(z, k, normalized({std::tan(0.14F), 0, 1}));
      Frames frames(view, noise_only(quantise), k);
      double sum = 0, sum_sq = 0;
      int count = 0;
      for (std::uint64_t f = 0; f < 4; ++f) {
        const auto& pixels = frames.take(f);
        for (int v = 0; v < kHeight; ++v) {
          for (int u = 140; u < 180; ++u) {
            const std::size_t at = view.at(u, v);
            const double truth = 1.0 / static_cast<double>(view.inverse_depth[at]);
            const double error = static_cast<double>(pixels[at]) - truth;
            sum += error;
            sum_sq += error * error;
            ++count;
          }
        }
      }
      const double mean = sum / count;
      const double sd = std::sqrt(sum_sq / count - mean * mean);
      const double metres = z / 1000;
      const double published = 1.2 + 1.9 * (metres - 0.4) * (metres - 0.4);
      EXPECT_NEAR(sd, published, 0.08 * published + 0.05) << "z " << z << " quantise " << quantise;
      EXPECT_NEAR(mean, 0, 0.05 * published + 0.15) << "z " << z << " quantise " << quantise;
    }
  }
}

TEST(DepthSensor, ChangedItIsAsNew) {
  const Intrinsics k = kinect_intrinsics(kWidth, kHeight);
  const CleanView view = wall_at(2100, k, normalized({0.4F, 0.1F, 1}));
  SensorOptions smooth = kinect_sensor();
  smooth.quantise = false;
  Frames changed(view, exact_sensor(), k);
  for (const SensorOptions& options : {kinect_sensor(), smooth, tof_sensor(), exact_sensor(), kinect_sensor()}) {
    changed.sensor.change(options);
    changed.sensor.prepare(view, whole(k.width, k.height));
    Frames fresh(view, options, k);
    EXPECT_EQ(changed.take(3), fresh.take(3));
  }
}

TEST(DepthSensor, GrazingSurfacesAreNoisier) {
  // 0.1/sqrt(z) t^2/(pi/2 - t)^2 mm at 80 degrees and 2 m: 0.1/1.414 * (1.396/0.1745)^2 = 4.53 mm on top.
  EXPECT_NEAR(axial_sigma_mm(2000, std::cos(80 * std::acos(-1.0) / 180)) - axial_sigma_mm(2000, 1), 4.53, 0.02);
  EXPECT_NEAR(axial_sigma_mm(2000, 1), 6.06, 0.01);
  EXPECT_NEAR(axial_sigma_mm(3000, 1), 14.04, 0.01);
}

TEST(DepthSensor, StepsAreKhoshelhams) {
  for (const double z : {800.0, 1500.0, 2000.0, 2500.0, 3000.0}) {
    int raw = 0;
    while (raw_to_mm(raw) < z) ++raw;
    const double middle = (raw_to_mm(raw) + raw_to_mm(raw - 1)) / 2;
    EXPECT_NEAR(raw_to_mm(raw) - raw_to_mm(raw - 1), 2.85e-6 * middle * middle, 0.03 * 2.85e-6 * middle * middle);
  }
  // The driver's formula at two raw values, worked by hand: m = ((raw - 800)/4 - .375) .1042,
  // z = 10 (m 120/(7.5 - m) + 120).
  EXPECT_NEAR(raw_to_mm(800), 1193.8, 0.1);
  EXPECT_NEAR(raw_to_mm(1000), 3864.2, 0.1);
}

TEST(DepthSensor, DeliversOnlyWholeSteps) {
  const Intrinsics k = kinect_intrinsics(kWidth, kHeight);
  const CleanView view = wall_at(2000, k, normalized({0.5F, 0.2F, 1}));
  std::set<int> allowed = {0};
  for (int raw = 0; raw < 1089; ++raw) {
    const double z = raw_to_mm(raw);
    if (z >= 500 && z <= 5000) allowed.insert(static_cast<int>(z + 0.5));
  }
  Frames frames(view, kinect_sensor(), k);
  std::set<int> seen;
  for (const std::uint16_t z : frames.take(0)) {
    ASSERT_TRUE(allowed.contains(z)) << z;
    seen.insert(z);
  }
  EXPECT_GT(seen.size(), 60U);
}

TEST(DepthSensor, ExactSensorRoundsToMillimetres) {
  const Intrinsics k = kinect_intrinsics(kWidth, kHeight);
  const CleanView view = wall_at(2345, k, normalized({0.3F, 0.2F, 1}));
  Frames frames(view, exact_sensor(), k);
  const auto& pixels = frames.take(3);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    ASSERT_NEAR(pixels[i], 1.0 / static_cast<double>(view.inverse_depth[i]), 0.5001);
}

TEST(DepthSensor, ScaleErrorScales) {
  const Intrinsics k = kinect_intrinsics(kWidth, kHeight);
  const CleanView view = wall_at(2000, k);
  SensorOptions o = exact_sensor();
  o.depth_scale = 1.003F;
  EXPECT_EQ(Frames(view, o, k).take(0)[0], 2006);
}

TEST(DepthSensor, RangeLimits) {
  const Intrinsics k = kinect_intrinsics(kWidth, kHeight);
  for (const auto& [z, expected] : {std::pair{450.0, false}, {700.0, true}, {5400.0, false}}) {
    const CleanView view = wall_at(z, k);
    SensorOptions o = kinect_sensor();
    o.holes = false;
    Frames frames(view, o, k);
    int delivered = 0;
    for (const std::uint16_t p : frames.take(0)) delivered += p != 0;
    EXPECT_EQ(delivered, expected ? kWidth * kHeight : 0) << z;
  }
}

// A plate 1 m before a wall: its shadow on the wall is f b (1/z1 - 1/z2) px wide, on the side away from the
// projector, which is towards +u.
TEST(DepthSensor, ShadowBesideANearEdge) {
  const Intrinsics k = kinect_intrinsics(640, 480);
  CleanView view = wall_at(2500, k);
  for (int v = 200; v < 280; ++v)
    for (int u = 300; u < 400; ++u) view.inverse_depth[view.at(u, v)] = 1.0F / 1500;
  SensorOptions o = exact_sensor();
  o.shadow = true;
  Frames frames(view, o, k);
  const auto& pixels = frames.take(0);
  const double width = 575.8 * 75 * (1.0 / 1500 - 1.0 / 2500);  // 11.5 px
  int lost = 0;
  for (int u = 0; u < 640; ++u) {
    const bool dark = pixels[view.at(u, 240)] == 0;
    lost += dark;
    if (dark) {
      EXPECT_LT(u, 300);
      EXPECT_GE(u, 300 - static_cast<int>(width) - 2);
    }
  }
  EXPECT_NEAR(lost, width, 1.01);
  EXPECT_NE(pixels[view.at(299 - 14, 240)], 0);
  EXPECT_NE(pixels[view.at(290, 150)], 0);  // other rows have none
}

// A vertical edge wanders from row to row by the lateral spread: 0.8 px at 640 wide, rounded to whole pixels.
TEST(DepthSensor, EdgesWander) {
  const Intrinsics k = kinect_intrinsics(640, 480);
  CleanView view = wall_at(2500, k);
  for (int v = 0; v < 480; ++v)
    for (int u = 320; u < 640; ++u) view.inverse_depth[view.at(u, v)] = 1.0F / 1500;
  Frames frames(view, noise_only(true), k);
  const auto& pixels = frames.take(0);
  double flipped = 0;
  for (int v = 0; v < 480; ++v) {
    EXPECT_GT(pixels[view.at(317, v)], 2300);
    EXPECT_LT(pixels[view.at(322, v)], 1700);
    flipped += (pixels[view.at(319, v)] < 2000) + (pixels[view.at(320, v)] > 2000);
  }
  // The neighbour's side is taken when the displacement rounds to one or more: P(N(0, .8) > .5) = .266.
  EXPECT_NEAR(flipped / (2 * 480), 0.266, 0.05);
}

TEST(DepthSensor, HolesAreFewAndDependOnTheFrame) {
  const Intrinsics k = kinect_intrinsics(640, 480);
  const CleanView view = wall_at(2000, k);
  Frames frames(view, kinect_sensor(), k);
  const auto count = [&](std::uint64_t f) {
    int lost = 0;
    for (const std::uint16_t p : frames.take(f)) lost += p == 0;
    return lost;
  };
  const int first = count(0);
  EXPECT_GT(first, 10);
  EXPECT_LT(first, 1500);
  EXPECT_NE(first, count(1));
}

TEST(DepthSensor, FramesDependOnSeedAndIndexOnly) {
  const Intrinsics k = kinect_intrinsics(640, 480);
  const CleanView view = wall_at(2000, k, normalized({0.4F, 0.1F, 1}));
  Frames a(view, kinect_sensor(), k), b(view, kinect_sensor(), k);
  const auto seventh = a.take(7);
  b.take(3);
  b.take(12);
  EXPECT_EQ(b.take(7), seventh);
  EXPECT_NE(b.take(8), seventh);
  EXPECT_NE(b.take(7, 6), seventh);
}

TEST(DepthSensor, ABoxHoldsTheSamePixels) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  CleanView view = wall_at(2500, k);
  for (int v = 60; v < 200; ++v)
    for (int u = 100; u < 170; ++u) view.inverse_depth[view.at(u, v)] = 1.0F / 2000;
  Frames frames(view, kinect_sensor(), k);
  const auto full = frames.take(4);
  const PixelBox box{90, 50, 180, 210};
  DepthSensor sensor(kinect_sensor(), k);
  sensor.prepare(view, box);
  std::vector<std::uint16_t> part(full.size());
  sensor.expose(view, box, 5, 4, DepthImage(part.data(), k.width, k.height), nullptr);
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const bool inside = u >= box.u0 && u < box.u1 && v >= box.v0 && v < box.v1;
      ASSERT_EQ(part[view.at(u, v)], inside ? full[view.at(u, v)] : 0);
    }
}

// Neighbours share part of their noise: correlation of horizontal neighbours well above zero, of far ones none.
TEST(DepthSensor, NoiseIsPatchy) {
  const Intrinsics k = kinect_intrinsics(640, 480);
  const CleanView view = wall_at(2000, k);
  Frames frames(view, noise_only(false), k);
  const auto& pixels = frames.take(0);
  const auto correlation = [&](int apart) {
    double cross_sum = 0, square_sum = 0;
    for (int v = 0; v < 480; ++v)
      for (int u = 0; u + 40 < 640; ++u) {
        const double a = pixels[view.at(u, v)] - 2000.0;
        cross_sum += a * (pixels[view.at(u + apart, v)] - 2000.0);
        square_sum += a * a;
      }
    return cross_sum / square_sum;
  };
  EXPECT_GT(correlation(1), 0.3);
  EXPECT_NEAR(correlation(24), 0, 0.03);
}

std::int32_t pixel(const RawRow& row, int i) {
  Rng draws(row.seed + kRowStep * static_cast<std::uint64_t>(i));
  const std::uint64_t bits = draws.next();
  Rng again(row.seed + kRowStep * static_cast<std::uint64_t>(i));
  const float white = again.fast_normal();
  const auto chance = static_cast<std::int32_t>((bits * 0xD1342543DE82EF95ULL) >> 48);
  const float raw = row.exact[i] + row.sigma[i] * (row.white_share * white + row.patch_share * row.patch[i]);
  if (chance < row.lost[i] || raw < -0.5F) return 2048;
  return raw + 0.5F > 2047.0F ? 2047 : static_cast<std::int32_t>(raw + 0.5F);
}

// The sensor's innermost loop against the same arithmetic written pixel by pixel.
TEST(RawRow, EveryVariantIsThePixelsArithmetic) {
  std::vector<RawRowFunction*> variants = {raw_row_portable, fastest_raw_row()};
  Rng rng(3);
  for (int trial = 0; trial < 400; ++trial) {
    const int count = 1 + rng.index(200);
    const auto n = static_cast<std::size_t>(count);
    std::vector<float> exact(n), sigma(n), patch(n);
    std::vector<std::int32_t> lost(n), out(n);
    for (std::size_t i = 0; i < n; ++i) {
      // Mostly ordinary; at both ends of the steps, far beyond them, and surely lost.
      const int kind = rng.index(8);
      exact[i] = static_cast<float>(kind == 0   ? rng.uniform(-2, 2)
                                    : kind == 1 ? rng.uniform(2045, 2050)
                                    : kind == 2 ? rng.uniform(-1e5, 1e6)
                                                : rng.uniform(300, 1000));
      sigma[i] = static_cast<float>(rng.uniform(0, kind == 3 ? 500 : 2));
      patch[i] = rng.fast_normal();
      lost[i] = kind == 4 ? 65536 : kind == 5 ? rng.index(65536) : rng.index(40);
    }
    const bool silent = trial % 10 == 0;
    const RawRow row{rng.next(),   exact.data(),         sigma.data(),         lost.data(),
                     patch.data(), silent ? 0.0F : 0.7F, silent ? 0.0F : 0.71F};
    for (RawRowFunction* variant : variants) {
      variant(row, count, out.data());
      for (int i = 0; i < count; ++i)
        ASSERT_EQ(out[static_cast<std::size_t>(i)], pixel(row, i)) << "trial " << trial << " pixel " << i;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t bits = Rng(row.seed + kRowStep * i).next();
      const RawPixel alone{bits, exact[i], sigma[i], lost[i], patch[i], row.white_share, row.patch_share};
      ASSERT_EQ(raw_step(alone), pixel(row, static_cast<int>(i))) << "trial " << trial << " pixel " << i;
    }
  }
}

}  // namespace
}  // namespace im2fit::lab
