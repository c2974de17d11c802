// SPDX-License-Identifier: Apache-2.0
// Recordings of other programs, written here as those write them: with libpng and plain text.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "hal/folder/scanner_3d_app.h"
#include "hal/folder/tum_folder.h"
#include "hal/open/open.h"
#include "made_folder.h"
#include "small_png.h"

namespace im2fit::hal {
namespace {

class Recorders : public testing::Test {
 protected:
  std::string path(const std::string& name = "") const { return folder_.path(name.empty() ? "rec" : "rec/" + name); }
  void SetUp() override { std::filesystem::create_directory(path()); }
  std::string refused() const {
    const auto source = open_source(path());
    EXPECT_FALSE(source);
    if (source) return "";
    EXPECT_FALSE(contains(source.error().message, "\n"));
    return source.error().message;
  }
  TestFolder folder_;
};

Vec3f turned(const CameraPose& q, Vec3f v) {
  const Vec3f axis = {q.x, q.y, q.z};
  return v + cross(axis, cross(axis, v) + v * q.w) * 2;
}

class Tum : public Recorders {
 protected:
  // Pixel (u, v) of frame i has (2 + i) metres.
  void make(int count = 3) {
    std::filesystem::create_directory(path("depth"));
    std::string list = "# depth maps\n# file: 'freiburg1.bag'\n# timestamp filename\n";
    for (int i = 0; i < count; ++i) {
      const std::string name = "depth/" + time(i) + ".png";
      write_grey_png(path(name), 640, 480, 16,
                     [&](int u, int v) { return u == 100 && v == 50 ? 10000 + 5000 * i : 3; });
      list += time(i) + " " + name + "\n";
    }
    put(path("depth.txt"), list);
  }
  static std::string time(int i) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6f", 1305031102.160407 + i / 30.0);
    return text;
  }
};

TEST_F(Tum, FramesHaveMillimetresTimesAndTheBenchmarksLens) {
  make();
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.intrinsics.fx, 525);
  EXPECT_EQ(info.intrinsics.cx, 319.5F);
  EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::field_of_view) << "an assumption is no calibration";
  EXPECT_EQ(info.frame_count, 3);
  Picture out(640, 480);
  for (int i = 0; i < 3; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(out.view().at(100, 50), 2000 + 1000 * i);
    EXPECT_EQ(out.view().at(0, 0), 1);  // 0.6 mm
    EXPECT_NEAR(static_cast<double>(frame->host_ns), (1305031102.160407 + i / 30.0) * 1e9, 1e3);
    EXPECT_FALSE(frame->pose);
  }
  EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
}

TEST_F(Tum, PicturesNamedByTimesNeedNoList) {
  make();
  std::filesystem::remove(path("depth.txt"));
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  Picture out(640, 480);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_EQ(out.view().at(100, 50), 4000);
}

TEST_F(Tum, PosesAreThoseOfTheFramesTimes) {
  make();
  std::string table = "# timestamp tx ty tz qx qy qz qw\n";
  // Exact for frame 0; around frame 1, half the way; none near frame 2.
  table += time(0) + " 1.0 2.0 3.0 0 0 0 1\n";
  char line[120];
  const double middle = 1305031102.160407 + 1 / 30.0;
  std::snprintf(line, sizeof line, "%.6f 1 2 3 0 0 0 1\n", middle - 0.002);
  table += line;
  std::snprintf(line, sizeof line, "%.6f 1.1 2 3 0 0 0.0 -1\n", middle + 0.002);
  table += line;
  put(path("groundtruth.txt"), table);
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  Picture out(640, 480);
  const auto first = (*source)->next(out.image(), 0);
  ASSERT_TRUE(first && first->pose);
  EXPECT_EQ(first->pose->position_mm.z, 3000);
  const auto second = (*source)->next(out.image(), 0);
  ASSERT_TRUE(second && second->pose);
  EXPECT_NEAR(second->pose->position_mm.x, 1050, 0.2);
  EXPECT_NEAR(std::abs(second->pose->w), 1, 1e-6) << "q and -q are one turn";
  table = "";
  std::snprintf(line, sizeof line, "%.6f 1 2 3 0 0 0 1\n", middle + 10);
  put(path("groundtruth.txt"), line);
  source = open_source(path());
  ASSERT_TRUE(source);
  const auto without = (*source)->next(out.image(), 0);
  ASSERT_TRUE(without);
  EXPECT_FALSE(without->pose);
}

TEST_F(Tum, ACalibrationAndAUnitOfTheCallersAreTaken) {
  make(1);
  put(path("camera.yaml"), yaml_of({640, 480, 517, 516, 318, 255}, "fr1", 0));
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics.fx, 517);
  EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::calibration_file);
  OpenOptions options;
  options.unit_mm = 0.1;
  source = open_source(path(), options);
  ASSERT_TRUE(source) << source.error().message;
  Picture out(640, 480);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_EQ(out.view().at(100, 50), 1000);
}

TEST_F(Tum, WhatIsWrongIsNamedInOneLine) {
  make(1);
  const std::string name = "depth/" + time(0) + ".png";
  const std::pair<std::string, const char*> kLists[] = {
      {"# nothing\n", "has no row"},
      {time(0) + "\n", "depth.txt line 1: expected a time"},
      {"soon " + name + "\n", "depth.txt line 1: 'soon' is not a time"},
      {"# x\n2 " + name + "\n1 " + name + "\n", "depth.txt line 3: the time is not after"},
      {"1 ../../etc/picture.png\n", "is not a file within the folder"},
      {"1 /etc/picture.png\n", "is not a file within the folder"},
      {"1 depth/none.png\n", "none.png"}};
  for (const auto& [list, words] : kLists) {
    put(path("depth.txt"), list);
    EXPECT_TRUE(contains(refused(), words)) << refused();
  }
  put(path("depth.txt"), "1 " + name + "\n");
  const std::pair<std::string, const char*> kPoses[] = {{"1 0 0 0 0 0 0\n", "groundtruth.txt line 1: expected"},
                                                        {"1 0 0 0 0 0 0 2\n", "unit quaternion"},
                                                        {"1 0 0 nan 0 0 0 1\n", "is not a number"},
                                                        {"1 0 0 1e6 0 0 0 1\n", "kilometre"}};
  for (const auto& [table, words] : kPoses) {
    put(path("groundtruth.txt"), table);
    EXPECT_TRUE(contains(refused(), words)) << refused();
  }
  std::filesystem::remove(path("groundtruth.txt"));
  write_grey_png(path(name), 320, 240, 16, [](int, int) { return 1; });
  EXPECT_TRUE(contains(refused(), "320x240 and no calibration; give --camera")) << refused();
}

class ScannerApp : public Recorders {
 protected:
  static std::string number(int i) {
    char text[16];
    std::snprintf(text, sizeof text, "%05d", i);
    return text;
  }
  // The camera in ARKit's world (y up) 1.4 m above the floor, looking along -z and 20 cm further left each frame;
  // held upright, so that x of its picture points down. Rows of ARKit's camera-to-world: x down, y right, z
  // backwards.
  void frame(int i, const std::string& matrix = "",
             const std::string& lens =
                 "1443.75, 0, 955.1, 0, 1443.75, 722.9, 0, "
                 "0, 1") {
    const std::string place = std::to_string(-0.2 * i);
    put(path("frame_" + number(i) + ".json"),
        "{\n\t\"time\" : " + std::to_string(5000.25 + i) + ",\n\t\"cameraPoseARFrame\" : [" +
            (matrix.empty() ? "0, 1, 0, " + place + ", -1, 0, 0, 1.4, 0, 0, 1, 0, 0, 0, 0, 1" : matrix) +
            "],\n\t\"motionQuality\" : 0.9,\n\t\"intrinsics\" : [" + lens +
            "],\n\t\"projectionMatrix\" : [1, 0, 0, 0],\n\t\"averageVelocity\" : 0.1\n}\n");
  }
  void make(int count = 3) {
    for (int i = 0; i < count; ++i) {
      frame(i);
      write_grey_png(path("depth_" + number(i) + ".png"), 256, 192, 16,
                     [&](int u, int v) { return u == 60 && v == 100 ? 2000 : 0; });
      write_grey_png(path("conf_" + number(i) + ".png"), 256, 192, 8, [](int, int) { return 2; });
    }
    frame(count);  // the app keeps depth of some frames only
  }
};

TEST_F(ScannerApp, FramesAreUprightWithPosesGravityAndTheScaledLens) {
  make();
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.rotate_deg, 90);
  EXPECT_EQ(info.intrinsics.width, 192);
  EXPECT_NEAR(info.intrinsics.fx, 192.5, 1e-3);
  EXPECT_NEAR(info.intrinsics.cy, 955.6 * 256 / 1920 - 0.5, 1e-3);
  EXPECT_EQ(info.frame_count, 3);
  EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::recording);
  EXPECT_EQ(info.sensor, SensorKind::time_of_flight);
  Picture out(192, 256);
  Vec3f first;
  for (int i = 0; i < 3; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(out.view().at(192 - 1 - 100, 60), 2000);
    ASSERT_TRUE(frame->pose && frame->down);
    EXPECT_NEAR(frame->down->y, 1, 1e-5);
    EXPECT_NEAR(static_cast<double>(frame->host_ns), (5000.25 + i) * 1e9, 1e3);
    // The phone moves left, so what stands still moves right in the picture.
    const Vec3f ahead = turned(*frame->pose, {0, 0, 1});
    const Vec3f right = turned(*frame->pose, {1, 0, 0});
    if (i == 0) first = frame->pose->position_mm;
    const Vec3f moved = frame->pose->position_mm - first;
    EXPECT_NEAR(dot(moved, right), -200 * i, 0.1);
    EXPECT_NEAR(dot(moved, ahead), 0, 0.1);
  }
}

TEST_F(ScannerApp, PixelsOfLowConfidenceHaveNoDepth) {
  make(2);
  write_grey_png(path("conf_00001.png"), 256, 192, 8, [](int, int) { return 1; });
  auto source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
  Picture out(192, 256);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_EQ(out.view().at(91, 60), 2000);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_EQ(out.view().at(91, 60), 0);
  std::filesystem::remove(path("conf_00000.png"));
  std::filesystem::remove(path("conf_00001.png"));
  source = open_source(path());
  ASSERT_TRUE(source) << source.error().message;
}

TEST_F(ScannerApp, WhatIsWrongIsNamedInOneLine) {
  make(2);
  const std::pair<std::string, const char*> kMatrices[] = {
      {"1, 0, 0", "frame_00001.json: cameraPoseARFrame is missing or not a 4 x 4"},
      {"0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, -0.2, 1.4, 0, 1", "row by row"},
      {"0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1", "not a rotation"},
      {"0, 1, 0, 1e9, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1", "kilometre"}};
  for (const auto& [matrix, words] : kMatrices) {
    frame(1, matrix);
    EXPECT_TRUE(contains(refused(), words)) << refused();
  }
  for (int i = 0; i < 3; ++i) frame(i, "", "1443, 0, 1e30, 0, 1443, 722, 0, 0, 1");
  EXPECT_TRUE(contains(refused(), "has its centre at (1e+30, 722)")) << refused();
  frame(0);
  frame(1, "", "1, 2, 3");
  EXPECT_TRUE(contains(refused(), "intrinsics is missing or not a 3 x 3 matrix")) << refused();
  put(path("frame_00001.json"), "{\"time\": ");
  EXPECT_TRUE(contains(refused(), "frame_00001.json line")) << refused();
  std::filesystem::remove(path("frame_00001.json"));
  EXPECT_TRUE(contains(refused(), "has no row for")) << refused();
}

// Item by item: what was found, and one command.
TEST_F(Recorders, OtherRecordingsAreNamedWithTheCommandThatConvertsThem) {
  const std::pair<const char*, const char*> kFiles[] = {{"a.r3d", "EXR"},
                                                        {"A.MP4", "no millimetres"},
                                                        {"it's.stl", "of a kind that is not read"},
                                                        {"a.npy", "give its folder"},
                                                        {"a.raw", "im2fit-lab import-raw"}};
  for (const auto& [name, words] : kFiles) {
    put(path(name), "x");
    const auto source = open_source(path(name));
    ASSERT_FALSE(source);
    EXPECT_TRUE(contains(source.error().message, words)) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, name)) << source.error().message;
  }
  const std::pair<const char*, const char*> kFolders[] = {
      {"frame.npy", "*.npy"},      {"b.raw", "import-raw"},           {"c.TIFF", "*.tif*"},     {"d.exr", "*.exr"},
      {"e.mp4", "no millimetres"}, {"f.mkv", "give the file itself"}, {"left.png", "no number"}};
  for (const auto& [name, words] : kFolders)
    for (const bool inner : {false, true}) {
      std::filesystem::remove_all(path());
      std::filesystem::create_directories(path("depth"));
      put(path((inner ? "depth/" : "") + std::string(name)), "x");
      EXPECT_TRUE(contains(refused(), words)) << refused();
      EXPECT_TRUE(contains(refused(), "holds 1 ")) << refused();
    }
  std::filesystem::remove_all(path());
  std::filesystem::create_directories(path("depth"));
  put(path("depth/000.npy"), std::string("\x93NUMPY\x01\0v\0{'descr': '<f4', 'fortran_order': False", 50));
  EXPECT_TRUE(contains(refused(), "*1000")) << "metres: " << refused();
  std::filesystem::remove_all(path("depth"));
  EXPECT_TRUE(contains(refused(), "holds no depth frames"));
  std::filesystem::create_directories(path("depth"));
  write_grey_png(path("depth/000000.png"), 64, 48, 16, [](int, int) { return 1; });
  EXPECT_TRUE(contains(refused(), "in depth/; give ")) << refused();
  // A depth folder without its calibration is still one.
  put(path("a.npy"), "x");
  write_grey_png(path("000000.png"), 64, 48, 16, [](int, int) { return 1; });
  EXPECT_TRUE(contains(refused(), "camera.yaml is missing")) << refused();
}

}  // namespace
}  // namespace im2fit::hal
