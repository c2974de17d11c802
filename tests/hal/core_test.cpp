// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "hal/intrinsics.h"
#include "hal/known_sensors.h"
#include "hal/source.h"
#include "hal/synthetic_source.h"
#include "hal/undistort.h"
#include "support.h"
#include "tests/kernels/checkasm.h"

namespace im2fit::hal {
namespace {

bool quarter(int rotate_deg) {
  return rotate_deg == 90 || rotate_deg == 270;
}

Picture turned(const Picture& in, int rotate_deg) {
  Picture out(quarter(rotate_deg) ? in.height : in.width, quarter(rotate_deg) ? in.width : in.height);
  rotate_upright(in.view(), rotate_deg, out.image());
  return out;
}

TEST(Rotate, NinetyPutsTheCornersWhereTheDefinitionSays) {
  Picture in(3, 2);
  in.pixels = {1, 2, 3,  //
               4, 5, 6};
  EXPECT_EQ(turned(in, 90).pixels, (std::vector<std::uint16_t>{4, 1, 5, 2, 6, 3}));
  EXPECT_EQ(turned(in, 180).pixels, (std::vector<std::uint16_t>{6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(turned(in, 270).pixels, (std::vector<std::uint16_t>{3, 6, 2, 5, 1, 4}));
  EXPECT_EQ(turned(in, 0).pixels, in.pixels);
}

TEST(Rotate, FourQuarterTurnsAndInversesGiveThePictureBack) {
  for (const auto& [width, height] : {std::pair{640, 480}, {33, 65}, {1, 7}, {32, 32}}) {
    const Picture in = random_picture(width, height, 5);
    EXPECT_EQ(turned(turned(in, 90), 270).pixels, in.pixels);
    EXPECT_EQ(turned(turned(in, 270), 90).pixels, in.pixels);
    EXPECT_EQ(turned(turned(in, 180), 180).pixels, in.pixels);
    EXPECT_EQ(turned(turned(turned(turned(in, 90), 90), 90), 90).pixels, in.pixels);
    EXPECT_EQ(turned(turned(in, 90), 90).pixels, turned(in, 180).pixels);
  }
}

TEST(Rotate, StridesOfBothSidesAreKept) {
  Picture wide = random_picture(50, 20, 9);
  const DepthView part(wide.pixels.data() + 3, 40, 20, 50);
  Picture dense(40, 20);
  for (int v = 0; v < 20; ++v)
    for (int u = 0; u < 40; ++u) dense.image().at(u, v) = part.at(u, v);
  Picture room(30, 40);
  rotate_upright(part, 90, DepthImage(room.pixels.data() + 5, 20, 40, 30));
  const Picture expected = turned(dense, 90);
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 20; ++u) ASSERT_EQ(room.view().at(u + 5, v), expected.view().at(u, v));
}

// A pixel and the one it moves to are the same ray, turned about the optical axis: by +90 degrees (x, y) -> (-y, x).
TEST(Rotate, PixelsAndIntrinsicsTurnTheSameRay) {
  const Intrinsics camera = camera_of(640, 480);
  const struct {
    int degrees, xx, xy, yx, yy;
  } turns[] = {{0, 1, 0, 0, 1}, {90, 0, -1, 1, 0}, {180, -1, 0, 0, -1}, {270, 0, 1, -1, 0}};
  for (const auto& turn : turns) {
    const Intrinsics upright = rotate_upright(camera, turn.degrees);
    for (const auto& [u, v] : {std::pair{0, 0}, {639, 479}, {17, 400}, {600, 3}}) {
      Picture in(640, 480);
      in.image().at(u, v) = 2345;
      const Picture out = turned(in, turn.degrees);
      int found = 0;
      for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
          if (out.view().at(x, y) == 0) continue;
          ++found;
          const Vec3f was = unproject(camera, static_cast<float>(u), static_cast<float>(v), 2345);
          const Vec3f is = unproject(upright, static_cast<float>(x), static_cast<float>(y), 2345);
          EXPECT_NEAR(is.x, static_cast<float>(turn.xx) * was.x + static_cast<float>(turn.xy) * was.y, 1e-3);
          EXPECT_NEAR(is.y, static_cast<float>(turn.yx) * was.x + static_cast<float>(turn.yy) * was.y, 1e-3);
        }
      }
      EXPECT_EQ(found, 1);
    }
    EXPECT_EQ(upright.width, quarter(turn.degrees) ? 480 : 640);
    EXPECT_TRUE(check_intrinsics(upright, "turned"));
  }
}

TEST(Undistort, GivesWhatLookingUpEachPixelGives) {
  checkasm::Trial trial;
  for (const int pixels : checkasm::odd_sizes(90)) {
    for (int repeat = 0; repeat < 6; ++repeat) {
      IM2FIT_CHECK_PARAMETERS(trial, pixels << ", repeat " << repeat);
      const auto size = static_cast<std::size_t>(pixels);
      std::vector<std::int32_t> table;
      const int longest = 1 + trial.rng().index(30);
      while (table.size() < size) {
        const int from = trial.rng().index(pixels), none = trial.rng().index(5) == 0 ? 1 : 0;
        for (int k = trial.rng().index(longest); k >= 0 && table.size() < size; --k)
          table.push_back(none != 0 || from + k >= pixels ? -1 : from + k);
        if (repeat == 0) table.assign(size, 0);  // one pixel everywhere
      }
      if (repeat == 1)
        for (std::size_t i = 0; i < size; ++i) table[i] = static_cast<std::int32_t>(i);  // no lens
      if (repeat == 2)
        for (std::size_t i = 0; i < size; ++i) table[i] = std::max(0, static_cast<std::int32_t>(i) - 3);
      const std::vector<UndistortRun> runs = undistort_runs(table);
      checkasm::Buffer<std::uint16_t> in(size, trial.next_end()), want(size), got(size, trial.next_end());
      trial.fill(in.span());
      for (std::size_t i = 0; i < size; ++i)
        want[i] = table[i] < 0 ? std::uint16_t{0} : in[static_cast<std::size_t>(table[i])];
      undistort(in.data(), pixels, runs, got.data());
      checkasm::expect_same_bits(want, got);
    }
  }
}

TEST(UndistortRuns, AreAsFewAsCanBe) {
  const std::vector<std::int32_t> table = {3, 4, 5, -1, -1, 9, 8, 9, 10, -1};
  const std::vector<UndistortRun> runs = undistort_runs(table);
  ASSERT_EQ(runs.size(), 5U);
  EXPECT_EQ(runs[0].count, 3);
  EXPECT_EQ(runs[1].from, -1);
  EXPECT_EQ(runs[3].to, 6);
  EXPECT_EQ(runs[3].from, 8);
  EXPECT_EQ(runs[3].count, 3);
}

TEST(Intrinsics, AbsurdOnesAreRefusedByName) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const struct {
    Intrinsics k;
    const char* names;
  } cases[] = {
      {{0, 480, 575, 575, 320, 240}, "size"},  {{640, 4096, 575, 575, 320, 240}, "size"},
      {{640, 480, 0, 575, 320, 240}, "fx"},    {{640, 480, nan, 575, 320, 240}, "fx"},
      {{640, 480, 575, -575, 320, 240}, "fy"}, {{640, 480, 575, inf, 320, 240}, "fy"},
      {{640, 480, 575, 575, nan, 240}, "cx"},  {{640, 480, 575, 575, 320, -240}, "cy"},
      {{640, 480, 575, 575, 3200, 240}, "cx"}, {{640, 480, 1e9F, 575, 320, 240}, "fx"},
      {{640, 480, 575, 5, 320, 240}, "fy"},    {{640, 480, 2000, 500, 320, 240}, "ratio"},
  };
  for (const auto& bad : cases) {
    const auto status = check_intrinsics(bad.k, "THE CAMERA");
    ASSERT_FALSE(status) << bad.names;
    EXPECT_TRUE(contains(status.error().message, bad.names)) << status.error().message;
    EXPECT_TRUE(contains(status.error().message, "THE CAMERA")) << status.error().message;
  }
  EXPECT_TRUE(check_intrinsics({640, 480, 575.8F, 575.8F, 319.5F, 239.5F}, "Kinect"));
}

TEST(Intrinsics, FieldOfViewComesBack) {
  for (const float f : {287.9F, 525.0F, 575.8F, 1081.37F}) {
    const Intrinsics k{640, 480, f, f * 0.99F, 319.5F, 239.5F};
    const FieldOfView view = field_of_view(k);
    const auto back = intrinsics_from_field_of_view(640, 480, view.horizontal_rad, view.vertical_rad, "test");
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->fx, k.fx, 0.01);
    EXPECT_NEAR(back->fy, k.fy, 0.01);
    EXPECT_EQ(back->cx, k.cx);
    EXPECT_EQ(back->cy, k.cy);
  }
  // A right angle over 640 px: half the width is the focal length.
  const auto right = intrinsics_from_field_of_view(640, 480, 1.57079633F, 1.2870022F, "test");
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->fx, 320, 1e-3);
  EXPECT_NEAR(right->fy, 320, 1e-3);
  for (const float bad : {0.0F, -1.0F, 4.0F, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_FALSE(intrinsics_from_field_of_view(640, 480, bad, 0.8F, "test"));
}

TEST(KnownSensors, AreThoseThatProjectPatterns) {
  EXPECT_EQ(sensor_of_usb(0x1D27, 0x0600), SensorKind::structured_light);
  EXPECT_EQ(sensor_of_usb(0x045E, 0x02AE), SensorKind::structured_light);
  EXPECT_EQ(sensor_of_usb(0x045E, 0x02BF), SensorKind::structured_light);
  EXPECT_EQ(sensor_of_usb(0x045E, 0x02B0), SensorKind::unknown) << "the motor";
  EXPECT_EQ(sensor_of_usb(0, 0), SensorKind::unknown);
}

TEST(SyntheticSource, DeliversTheGeneratorsFramesUprightUntilItEnds) {
  SourceInfo info;
  info.rotate_deg = 270;
  const auto make = [](std::uint64_t index, DepthImage out) {
    const Picture frame = random_picture(40, 30, index);
    rotate_upright(frame.view(), 0, out);
    return index < 3;
  };
  auto source = SyntheticSource::create(camera_of(40, 30), info, make);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::synthetic);
  Picture out(30, 40);
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto frame = (*source)->next(out.image(), 100);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->sequence, i);
    EXPECT_EQ(frame->device_us, static_cast<std::int64_t>(i) * 1'000'000 / 30);
    EXPECT_EQ(out.pixels, turned(random_picture(40, 30, i), 270).pixels);
  }
  EXPECT_EQ((*source)->next(out.image(), 100).error().code, ErrorCode::end_of_stream);
}

TEST(SyntheticSource, ALiveOneSkipsFramesTheReaderMissed) {
  SourceInfo info;
  info.live = true;
  auto source = SyntheticSource::create(camera_of(16, 12), info, [](std::uint64_t, DepthImage) { return true; });
  ASSERT_TRUE(source);
  ASSERT_TRUE((*source)->start());
  Picture out(16, 12);
  ASSERT_TRUE((*source)->next(out.image(), 1000));
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  const auto late = (*source)->next(out.image(), 1000);
  ASSERT_TRUE(late);
  EXPECT_GE(late->sequence, 3U);
  EXPECT_EQ((*source)->stats().gaps, late->sequence - 1);
}

// Of any size, in images with more in a row than the picture.
TEST(Rotate, PutsEveryPixelInItsPlace) {
  constexpr int kMore = 3;
  constexpr std::uint16_t kOutside = 12345;
  for (const int width : {1, 7, 8, 17, 33, 72})
    for (const int height : {1, 6, 8, 25, 40}) {
      const Picture in = random_picture(width + kMore, height, static_cast<std::uint64_t>(100 * width + height));
      const DepthView view(in.pixels.data(), width, height, width + kMore);
      for (const int rotate_deg : {0, 90, 180, 270}) {
        const bool quarter = rotate_deg % 180 != 0;
        const int w = quarter ? height : width, h = quarter ? width : height;
        Picture out(w + kMore, h);
        out.pixels.assign(out.pixels.size(), kOutside);
        rotate_upright(view, rotate_deg, DepthImage(out.pixels.data(), w, h, w + kMore));
        for (int v = 0; v < h; ++v) {
          for (int u = 0; u < w; ++u) {
            const int x = rotate_deg == 0 ? u : rotate_deg == 90 ? v : rotate_deg == 180 ? w - 1 - u : h - 1 - v;
            const int y = rotate_deg == 0 ? v : rotate_deg == 90 ? w - 1 - u : rotate_deg == 180 ? h - 1 - v : u;
            ASSERT_EQ(out.image().at(u, v), view.at(x, y)) << width << 'x' << height << ' ' << rotate_deg;
          }
          for (int u = w; u < w + kMore; ++u) ASSERT_EQ(out.image().at(u, v), kOutside);
        }
      }
    }
}

}  // namespace
}  // namespace im2fit::hal
