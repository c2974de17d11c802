// SPDX-License-Identifier: Apache-2.0
// Recordings of Stray Scanner, written here as the app writes them: with libpng and plain text.
#include "hal/folder/stray_scanner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>

#include "hal/open/open.h"
#include "made_folder.h"
#include "small_png.h"

namespace im2fit::hal {
namespace {

constexpr int kWide = 256, kHigh = 192;
constexpr const char* kMatrix = "1443.75, 0.0, 955.1\n0.0, 1443.75, 722.9\n0.0, 0.0, 1.0";
constexpr const char* kHeader = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
constexpr double kScale = 256.0 / 1920;

using Vec = std::array<double, 3>;
using Mat = std::array<Vec, 3>;  // columns

Vec back(const Mat& m, const Vec& v) {
  Vec out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}
Vec crossed(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec unit(const Vec& a) {
  const double n = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  return {a[0] / n, a[1] / n, a[2] / n};
}

// How the phone is held: which axis of its camera (x right, y down, z forward of the landscape picture) points down.
enum class Held { landscape, portrait, upside_down, portrait_other };

// A phone in ARKit's world (y up, metres) at `at`, looking at `to`.
struct Phone {
  Vec at;
  Mat axes;  // of the camera: right, down, forward of its picture
  Phone(const Vec& place, const Vec& to, Held held) : at(place), axes{} {
    const Vec forward = unit({to[0] - at[0], to[1] - at[1], to[2] - at[2]});
    const Vec right = unit(crossed(forward, {0, 1, 0}));
    const Vec down = crossed(forward, right);
    const auto minus = [](const Vec& v) { return Vec{-v[0], -v[1], -v[2]}; };
    switch (held) {
      case Held::landscape:
        axes = {right, down, forward};
        break;
      case Held::portrait:
        axes = {down, minus(right), forward};
        break;
      case Held::upside_down:
        axes = {minus(right), minus(down), forward};
        break;
      case Held::portrait_other:
        axes = {minus(down), right, forward};
    }
  }
  // As the app writes it: ARKit's quaternion (camera with y up and z backwards) times half a turn about x.
  std::string row(const std::string& head) const {
    const Mat arkit = {axes[0], Vec{-axes[1][0], -axes[1][1], -axes[1][2]},
                       Vec{-axes[2][0], -axes[2][1], -axes[2][2]}};
    const auto m = [&](std::size_t r, std::size_t c) { return arkit[c][r]; };
    std::array<double, 4> q{};  // x y z w, of the largest
    const std::array<double, 4> four = {1 + m(0, 0) - m(1, 1) - m(2, 2), 1 - m(0, 0) + m(1, 1) - m(2, 2),
                                        1 - m(0, 0) - m(1, 1) + m(2, 2), 1 + m(0, 0) + m(1, 1) + m(2, 2)};
    const auto most = static_cast<std::size_t>(std::max_element(four.begin(), four.end()) - four.begin());
    const double by = 0.5 / std::sqrt(four[most]);
    const std::array<std::array<double, 4>, 4> table = {
        {{four[0], m(0, 1) + m(1, 0), m(0, 2) + m(2, 0), m(2, 1) - m(1, 2)},
         {m(0, 1) + m(1, 0), four[1], m(1, 2) + m(2, 1), m(0, 2) - m(2, 0)},
         {m(0, 2) + m(2, 0), m(1, 2) + m(2, 1), four[2], m(1, 0) - m(0, 1)},
         {m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1), four[3]}}};
    for (std::size_t i = 0; i < 4; ++i) q[i] = table[most][i] * by;
    char line[200];
    std::snprintf(line, sizeof line, "%s%.8g, %.8g, %.8g, %.8g, %.8g, %.8g, %.8g\n", head.c_str(), at[0], at[1],
                  at[2], q[3], q[2], -q[1], -q[0]);  // (x, y, z, w) times (1, 0, 0, 0)
    return line;
  }
  struct Seen {
    int u, v, mm;
  };
  Seen see(const Vec& point) const {
    const Vec p = back(axes, {point[0] - at[0], point[1] - at[1], point[2] - at[2]});
    const double f = 1443.75 * kScale, cx = 955.6 * kScale - 0.5, cy = 723.4 * kScale - 0.5;
    return {static_cast<int>(std::lround(cx + f * p[0] / p[2])), static_cast<int>(std::lround(cy + f * p[1] / p[2])),
            static_cast<int>(std::lround(1000 * p[2]))};
  }
};

std::string number(int i) {
  char text[16];
  std::snprintf(text, sizeof text, "%06d", i);
  return text;
}

// Frames in which one point of the world has a depth and nothing else.
constexpr Vec kPoint = {0.2, 1.1, -2.3};

class Stray : public testing::Test {
 protected:
  std::string path(const std::string& name = "") const { return folder_.path(name.empty() ? "rec" : "rec/" + name); }
  void make(Held held, int count = 3, bool header = true) {
    for (const char* name : {"rec", "rec/depth", "rec/confidence"})
      std::filesystem::create_directory(folder_.path(name));
    put(path("camera_matrix.csv"), kMatrix);
    std::string table = header ? kHeader : "";
    for (int i = 0; i < count; ++i) {
      const Phone phone({0.1 * i, 1.3 + 0.02 * i, 0.05 * i}, {0.1, 1.0, -2.4}, held);
      char head[64];
      std::snprintf(head, sizeof head, "%.6f, %s, ", 5000.25 + i / 60.0, number(i).c_str());
      table += phone.row(header ? head : "");
      const Phone::Seen seen = phone.see(kPoint);
      ASSERT_TRUE(seen.u > 1 && seen.u < kWide - 1 && seen.v > 1 && seen.v < kHigh - 1);
      write_grey_png(path("depth/" + number(i) + ".png"), kWide, kHigh, 16,
                     [&](int u, int v) { return u == seen.u && v == seen.v ? seen.mm : 0; });
      write_grey_png(path("confidence/" + number(i) + ".png"), kWide, kHigh, 8, [](int, int) { return 2; });
    }
    put(path("odometry.csv"), table);
  }
  // The one pixel with a depth, in the axes of the frame delivered; mm.
  static std::optional<Vec3f> point_of(const Picture& picture, const Intrinsics& k) {
    for (int v = 0; v < picture.height; ++v)
      for (int u = 0; u < picture.width; ++u) {
        const auto mm = static_cast<float>(picture.view().at(u, v));
        if (mm == 0) continue;
        return Vec3f{(static_cast<float>(u) - k.cx) / k.fx * mm, (static_cast<float>(v) - k.cy) / k.fy * mm, mm};
      }
    return std::nullopt;
  }
  Error refused() const {
    const auto source = open_source(path());
    EXPECT_FALSE(source);
    return source ? Error{} : source.error();
  }

  TestFolder folder_;
};

Vec3f by_quaternion(const CameraPose& q, Vec3f v) {
  const Vec3f axis = {q.x, q.y, q.z};
  return v + cross(axis, cross(axis, v) + v * q.w) * 2;
}

// Poses, intrinsics and rotation together: wherever the phone is and however it is held, the point is at one place of
// the world and gravity points down in the picture.
TEST_F(Stray, APointOfTheWorldStaysWhereItIsHoweverThePhoneIsHeld) {
  const std::pair<Held, int> kWays[] = {
      {Held::landscape, 0}, {Held::portrait, 90}, {Held::upside_down, 180}, {Held::portrait_other, 270}};
  for (const auto& [held, rotate_deg] : kWays) {
    std::filesystem::remove_all(path());
    make(held);
    auto source = open_source(path());
    ASSERT_TRUE(source) << source.error().message;
    const SourceInfo& info = (*source)->info();
    EXPECT_EQ(info.rotate_deg, rotate_deg);
    EXPECT_EQ(info.intrinsics.width, rotate_deg % 180 == 0 ? kWide : kHigh);
    EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::recording);
    EXPECT_EQ(info.sensor, SensorKind::time_of_flight);
    EXPECT_EQ(info.frame_count, 3);
    EXPECT_FALSE(info.live);
    Picture out(info.intrinsics.width, info.intrinsics.height);
    const Vec3f expected =
        rotate_upright(Vec3f{static_cast<float>(1000 * kPoint[0]), static_cast<float>(1000 * kPoint[1]),
                             static_cast<float>(1000 * kPoint[2])},
                       rotate_deg);
    for (int i = 0; i < 3; ++i) {
      const auto frame = (*source)->next(out.image(), 0);
      ASSERT_TRUE(frame) << frame.error().message;
      ASSERT_TRUE(frame->pose && frame->down);
      EXPECT_GT(frame->down->y, 0.95F);
      EXPECT_NEAR(norm(*frame->down), 1, 1e-5);
      EXPECT_NEAR(static_cast<double>(frame->host_ns), (5000.25 + i / 60.0) * 1e9, 1e3);
      EXPECT_EQ(frame->device_us, (frame->host_ns + 500) / 1000);
      const auto seen = point_of(out, info.intrinsics);
      ASSERT_TRUE(seen);
      // Half a pixel at 2.4 m is 6 mm.
      EXPECT_LT(norm(by_quaternion(*frame->pose, *seen) + frame->pose->position_mm - expected), 10) << i;
    }
  }
}

TEST_F(Stray, IntrinsicsAreThoseOfTheColourPictureScaledByItsPixelsCentres) {
  make(Held::landscape, 1);
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  const Intrinsics k = (*source)->info().intrinsics;
  EXPECT_NEAR(k.fx, 192.5, 1e-3);
  EXPECT_NEAR(k.fy, 192.5, 1e-3);
  EXPECT_NEAR(k.cx, 955.6 * kScale - 0.5, 1e-3);
  EXPECT_NEAR(k.cy, 723.4 * kScale - 0.5, 1e-3);
}

// Versions since 2026 write what the lens was for each frame; the matrix is the last one's.
TEST_F(Stray, TheLensOfEachFrameIsAveraged) {
  make(Held::landscape, 2);
  std::string table =
      "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy, distortion_center_x, distortion_center_y\n";
  table += "1.0, 000000, 0, 1, 0, 1, 0, 0, 0, 1425, 1425, 959.5, 719.5, , \n";
  table += "2.0, 000001, 0, 1, 0, 1, 0, 0, 0, 1455, 1455, 959.5, 719.5, , \n";
  put(path("odometry.csv"), table);
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_NEAR((*source)->info().intrinsics.fx, 192, 1e-3);
  EXPECT_NEAR((*source)->info().intrinsics.cx, 127.5, 1e-3);
}

TEST_F(Stray, PixelsOfLowConfidenceHaveNoDepth) {
  make(Held::landscape, 2);
  write_grey_png(path("confidence/000001.png"), kWide, kHigh, 8, [](int, int) { return 1; });
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWide, kHigh);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_TRUE(point_of(out, (*source)->info().intrinsics));
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_FALSE(point_of(out, (*source)->info().intrinsics));
  std::filesystem::remove_all(path("confidence"));
  source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_TRUE(point_of(out, (*source)->info().intrinsics)) << "recordings without confidence are read";
}

TEST_F(Stray, TheFirstVersionsTableWithoutHeaderIsRead) {
  make(Held::portrait, 3, false);
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().rotate_deg, 90);
  Picture out(kHigh, kWide);
  for (int i = 0; i < 3; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_TRUE(frame->pose);
    EXPECT_EQ(frame->host_ns, i * (1'000'000'000 / 60));
  }
}

TEST_F(Stray, TheCallersCalibrationAndRotationWin) {
  make(Held::portrait);
  put(folder_.path("camera.yaml"),
      yaml_of({kWide, kHigh, 200, 201, 127, 95}, "phone", 0) + "im2fit_confidence_min: 1\n");
  OpenOptions options;
  options.camera_yaml_path = folder_.path("camera.yaml");
  options.rotate_deg = 270;
  auto source = open_source(path(), options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics.fy, 200);
  EXPECT_EQ((*source)->info().rotate_deg, 270);
}

TEST_F(Stray, WhatIsWrongIsNamedInOneLine) {
  struct Case {
    std::function<void()> spoil;
    ErrorCode code;
    const char* words;
  };
  const auto odometry = [&](const std::string& rows) { put(path("odometry.csv"), kHeader + rows); };
  const Case kCases[] = {
      {[&] { std::filesystem::remove(path("camera_matrix.csv")); }, ErrorCode::not_found,
       "camera_matrix.csv is missing; copy the whole recording again, or give --camera FILE"},
      {[&] { put(path("camera_matrix.csv"), "1443.75, 0.0, 955.1\n0.0, 1443.75"); }, ErrorCode::corrupt,
       "camera_matrix.csv is not a matrix"},
      {[&] { put(path("camera_matrix.csv"), "1, 2, 3\n4, 5, 6\n7, 8, 9\n"); }, ErrorCode::corrupt,
       "camera_matrix.csv is not a matrix"},
      {[&] { put(path("camera_matrix.csv"), "nan, 0, 960\n0, 1443, 720\n0, 0, 1\n"); }, ErrorCode::corrupt,
       "camera_matrix.csv is not a matrix"},
      {[&] { put(path("camera_matrix.csv"), "960, 0, 640\n0, 960, 360\n0, 0, 1\n"); }, ErrorCode::invalid_argument,
       "camera_matrix.csv has its centre at (640, 360), expected near (960, 720)"},
      {[&] { put(path("camera_matrix.csv"), "1e-3, 0, 960\n0, 1e-3, 720\n0, 0, 1\n"); }, ErrorCode::invalid_argument,
       "camera_matrix.csv"},
      {[&] { odometry(""); }, ErrorCode::corrupt, "odometry.csv has no row"},
      {[&] { odometry("1.0, 000000, 0, 1, 0, 1, 0, 0, 0\n"); }, ErrorCode::corrupt, "odometry.csv has no row for "},
      {[&] { odometry("1.0, 000000, 0, 1, 0, 1, 0, 0, 0\n1.0, 000001, 0, 1, 0, 1, 0, 0, 0\n"); }, ErrorCode::corrupt,
       "odometry.csv line 3: timestamp is not after that of the row before"},
      {[&] { odometry("1.0, 000000, 0, 1, 0, 1, 0, 0, 0\n2.0, 000000, 0, 1, 0, 1, 0, 0, 0\n"); }, ErrorCode::corrupt,
       "odometry.csv line 3: frame is 0, not after 0"},
      {[&] { odometry("1.0, 000000, 0, 1, 0, 1, 0, 0, 1\n"); }, ErrorCode::corrupt,
       "odometry.csv line 2: qx, qy, qz, qw have the length 1.41"},
      {[&] { put(path("odometry.csv"), "timestamp, frame, x\n"); }, ErrorCode::corrupt,
       "odometry.csv line 1: there is no column y"},
      {[&] { std::filesystem::remove_all(path("depth")), std::filesystem::create_directory(path("depth")); },
       ErrorCode::not_found, "depth holds no 000000.png"},
      {[&] {
         std::filesystem::remove_all(path("depth")), std::filesystem::create_directory(path("depth"));
         put(path("depth/000000.npy"), "x");
       },
       ErrorCode::unsupported, "depth holds .npy files"},
      {[&] { write_grey_png(path("depth/000000.png"), 640, 360, 16, [](int, int) { return 1; }); },
       ErrorCode::invalid_argument, "depth/000000.png is 640x360, expected sides of 4 to 3"},
      {[&] { write_grey_png(path("depth/000000.png"), kWide, kHigh, 8, [](int, int) { return 1; }); },
       ErrorCode::unsupported, "depth/000000.png is a 8-bit grey PNG"},
      {[&] { write_grey_png(path("confidence/000000.png"), 8, 8, 8, [](int, int) { return 2; }); },
       ErrorCode::invalid_argument, "confidence/000000.png is 8x8, expected 256x192"}};
  for (const Case& one : kCases) {
    SCOPED_TRACE(one.words);
    std::filesystem::remove_all(path());
    make(Held::portrait);
    one.spoil();
    const Error error = refused();
    EXPECT_EQ(error.code, one.code) << error.message;
    EXPECT_TRUE(contains(error.message, one.words)) << error.message;
    EXPECT_TRUE(contains(error.message, path())) << error.message;
    EXPECT_FALSE(contains(error.message, "\n")) << error.message;
  }
}

TEST_F(Stray, AFolderWithItsOwnCalibrationIsADepthFolder) {
  make_folder(path());
  std::filesystem::create_directory(path("depth"));
  put(path("camera_matrix.csv"), kMatrix);
  EXPECT_FALSE(is_stray_scanner(path()));
  EXPECT_EQ((*open_source(path()))->info().frame_count, 4);
}

// Pictures that somebody turned upright, without odometry.
TEST(StrayCase, TheSharedRecordingIsRead) {
  const char* given = std::getenv("IM2FIT_SHARED");
  const std::string path = std::string(given != nullptr ? given : "") + "/cases/stray-scanner";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << ": set IM2FIT_SHARED to the shared folder";
  auto source = open_source(path);
  ASSERT_TRUE(source) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.intrinsics.width, 480);
  EXPECT_EQ(info.intrinsics.height, 640);
  EXPECT_NEAR(info.intrinsics.fx, 1435.0 / 3, 1e-3);
  EXPECT_NEAR(info.intrinsics.cy, (958.6 + 0.5) / 3 - 0.5, 1e-3);
  EXPECT_EQ(info.rotate_deg, 0);
  Picture out(480, 640);
  const auto frame = (*source)->next(out.image(), 0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_FALSE(frame->pose);
  EXPECT_EQ(out.view().at(0, 0), 3407);
}

}  // namespace
}  // namespace im2fit::hal
