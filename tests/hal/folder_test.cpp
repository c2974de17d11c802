// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <utility>

#include "hal/folder/camera_yaml.h"
#include "hal/folder/frame_name.h"
#include "hal/intrinsics.h"
#include "hal/open/open.h"
#include "made_folder.h"

namespace im2fit::hal {
namespace {

class BothFormats : public testing::TestWithParam<DepthFormat> {};

TEST_P(BothFormats, EveryBitTimeAndIntrinsicComesBack) {
  const TestFolder folder;
  make_folder(folder.path("rec"), GetParam());
  auto source = open_source(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.frame_count, 4);
  EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::calibration_file);
  const Intrinsics camera = camera_of(kMadeWidth, kMadeHeight);
  EXPECT_EQ(info.intrinsics.fx, camera.fx);
  EXPECT_EQ(info.intrinsics.fy, camera.fy);
  EXPECT_EQ(info.intrinsics.cx, camera.cx);
  EXPECT_EQ(info.intrinsics.cy, camera.cy);
  Picture out(kMadeWidth, kMadeHeight);
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(out.pixels, random_picture(kMadeWidth, kMadeHeight, i).pixels);
    EXPECT_EQ(frame->sequence, i);
    EXPECT_EQ(frame->device_us, static_cast<std::int64_t>(1000 + i));
    EXPECT_EQ(frame->host_ns, static_cast<std::int64_t>(1000 + i) * 1000);
  }
  EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
  ASSERT_TRUE((*source)->start());
  EXPECT_TRUE((*source)->next(out.image(), 0)) << "start() begins again";
}
INSTANTIATE_TEST_SUITE_P(Folder, BothFormats, testing::Values(DepthFormat::png, DepthFormat::pgm));

// A camera says it once a second; the first row is mostly not the one.
TEST(Folder, WhereDownIsComesBackToTheBitUnlessTheFolderIsTurned) {
  const TestFolder folder;
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_TRUE(writer);
  const Picture picture = random_picture(kMadeWidth, kMadeHeight, 1);
  const Vec3f down{0.1F, 0.99498745F, -1e-9F};
  for (std::uint64_t i = 0; i < 4; ++i) {
    FrameInfo info{i, static_cast<std::int64_t>(i), -1};
    if (i == 2) info.down = down;
    ASSERT_TRUE((*writer)->write(picture.view(), info));
  }
  ASSERT_TRUE((*writer)->finish());
  Picture out(kMadeWidth, kMadeHeight);
  for (const int turned : {0, 180}) {
    OpenOptions options;
    options.rotate_deg = turned;
    auto source = open_source(folder.path("rec"), options);
    ASSERT_TRUE(source) << source.error().message;
    for (std::uint64_t i = 0; i < 4; ++i) {
      const auto frame = (*source)->next(out.image(), 0);
      ASSERT_TRUE(frame) << frame.error().message;
      ASSERT_EQ(frame->down.has_value(), i == 2 && turned == 0) << i;
      if (!frame->down) continue;
      EXPECT_EQ(frame->down->x, down.x);
      EXPECT_EQ(frame->down->y, down.y);
      EXPECT_EQ(frame->down->z, down.z);
    }
  }
}

TEST(Folder, AHandWrittenPgmIsReadByTheLetterOfItsStandard) {
  const TestFolder folder;
  put(folder.path("camera.yaml"), yaml_of({2, 2, 2, 2, 0.5F, 0.5F}, "tiny", 0));
  const char pgm[] = "P5 # a comment\n2\t2\n# another\n1000\n\x01\x02\x00\x00\x03\xE8\x00\xFF";
  put(folder.path("7.pgm"), std::string(pgm, sizeof pgm - 1));
  auto source = FolderSource::open(folder.path());
  ASSERT_TRUE(source) << source.error().message;
  Picture out(2, 2);
  const auto frame = (*source)->next(out.image(), 0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->sequence, 7U);
  EXPECT_EQ(out.pixels, (std::vector<std::uint16_t>{0x0102, 0, 1000, 255}));
}

TEST(Folder, RotationComesFromTheFileUnlessTheCallerSays) {
  const TestFolder folder;
  make_folder(folder.path("rec"));
  put(folder.path("rec/camera.yaml"), yaml_of(camera_of(kMadeWidth, kMadeHeight), "turned", 90));
  EXPECT_EQ((*open_source(folder.path("rec")))->info().intrinsics.width, kMadeHeight);
  OpenOptions options;
  options.rotate_deg = 180;
  EXPECT_EQ((*open_source(folder.path("rec"), options))->info().intrinsics.width, kMadeWidth);
  options.rotate_deg = 45;
  EXPECT_EQ(open_source(folder.path("rec"), options).error().code, ErrorCode::invalid_argument);
}

TEST(Folder, MissingNumbersAreCountedAsGaps) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::pgm, 6);
  std::filesystem::remove(folder.path("rec/000002.pgm"));
  std::filesystem::remove(folder.path("rec/000003.pgm"));
  auto source = FolderSource::open(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kMadeWidth, kMadeHeight);
  while ((*source)->next(out.image(), 0)) {
  }
  EXPECT_EQ((*source)->stats().delivered, 4U);
  EXPECT_EQ((*source)->stats().gaps, 2U);
}

TEST(Folder, GapsOfTheRecordingStayInTheNumbers) {
  const TestFolder folder;
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_TRUE(writer);
  const Picture frame = random_picture(kMadeWidth, kMadeHeight, 1);
  for (const std::uint64_t sequence : {100U, 101U, 104U})
    ASSERT_TRUE((*writer)->write(frame.view(), FrameInfo{sequence, static_cast<std::int64_t>(sequence), -1}));
  ASSERT_TRUE((*writer)->finish());
  EXPECT_TRUE(std::filesystem::exists(folder.path("rec/000004.png")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("rec/000002.png")));
}

// Each pixel of the camera's picture holds its own number. Undistorted pixel (u, v) must hold the pixel that the
// inverse of the lens, found by iteration, sends back to (u, v).
TEST(Folder, ALensIsUndone) {
  const TestFolder folder;
  Calibration calibration{{240, 200, 250, 245, 118.5F, 101.25F}, {{0.11, -0.21, 0.002, -0.003, 0.05, 0, 0, 0}}, 0};
  const auto& [k, distortion, rotate_deg, origin] = calibration;
  put(folder.path("camera.yaml"), camera_yaml_text(calibration, "lens"));
  EXPECT_EQ(load_camera_yaml(folder.path("camera.yaml"))->distortion.coefficients, distortion.coefficients);
  Picture in(k.width, k.height);
  for (std::size_t i = 0; i < in.pixels.size(); ++i) in.pixels[i] = static_cast<std::uint16_t>(i + 1);
  ASSERT_TRUE(write_file_atomically(folder.path("0.pgm"), *encode_depth(in.view(), DepthFormat::pgm)));
  auto source = FolderSource::open(folder.path());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics.fx, k.fx);
  Picture out(k.width, k.height);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  int checked = 0;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      if (out.view().at(u, v) == 0) continue;
      const int number = out.view().at(u, v) - 1;
      const double xd = (number % k.width - static_cast<double>(k.cx)) / static_cast<double>(k.fx);
      const double yd = (number / k.width - static_cast<double>(k.cy)) / static_cast<double>(k.fy);
      double x = xd, y = yd;
      for (int i = 0; i < 50; ++i) {
        const auto& c = distortion.coefficients;
        const double r2 = x * x + y * y;
        const double radial = 1 + c[0] * r2 + c[1] * r2 * r2 + c[4] * r2 * r2 * r2;
        x = (xd - 2 * c[2] * x * y - c[3] * (r2 + 2 * x * x)) / radial;
        y = (yd - c[2] * (r2 + 2 * y * y) - 2 * c[3] * x * y) / radial;
      }
      EXPECT_NEAR(x * static_cast<double>(k.fx) + static_cast<double>(k.cx), u, 0.6);
      EXPECT_NEAR(y * static_cast<double>(k.fy) + static_cast<double>(k.cy), v, 0.6);
      ++checked;
    }
  }
  EXPECT_GT(checked, k.width * k.height * 9 / 10);
  EXPECT_NE(out.pixels, in.pixels);
}

TEST(Folder, NamesOfCommonRecordersAreFrames) {
  const std::pair<const char*, int> kNames[] = {{"000012.png", 12},
                                                {"12.PNG", 12},
                                                {"depth_000012.png", 12},
                                                {"Depth-0012.PGM", 12},
                                                {"frame-000012.depth.png", 12},
                                                {"000012_depth.png", 12},
                                                {"image12.png", 12},
                                                {"IMG_0012.pgm", 12}};
  for (const auto& [name, number] : kNames) {
    ASSERT_TRUE(frame_number(name)) << name;
    EXPECT_EQ(*frame_number(name), static_cast<std::uint64_t>(number)) << name;
  }
  for (const char* name : {"overlay.png", "depth.png", "frame-000012.color.png", "color_000012.png", "12.jpg", ".png",
                           "1305031102.160407.png", "1234567890123456.png", "depth_-12.png"})
    EXPECT_FALSE(frame_number(name)) << name;
}

TEST(Folder, AUnitOtherThanMillimetresIsConverted) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 1);
  const Picture stored = random_picture(kMadeWidth, kMadeHeight, 0);
  for (const double unit_mm : {0.1, 0.125, 10.0}) {
    FolderOptions options;
    options.unit_mm = unit_mm;
    auto source = FolderSource::open(folder.path("rec"), options);
    ASSERT_TRUE(source);
    Picture out(kMadeWidth, kMadeHeight);
    ASSERT_TRUE((*source)->next(out.image(), 0));
    for (std::size_t i = 0; i < out.pixels.size(); ++i) {
      const double mm = stored.pixels[i] * unit_mm;
      ASSERT_NEAR(out.pixels[i], mm + 0.5 >= 65536 ? 0 : mm, 0.51) << unit_mm;
    }
  }
  OpenOptions of_no_folder;
  of_no_folder.unit_mm = 0.1;
  EXPECT_EQ(open_source("openni2", of_no_folder).error().code, ErrorCode::invalid_argument);
  FolderOptions absurd;
  absurd.unit_mm = -1;
  EXPECT_FALSE(FolderSource::open(folder.path("rec"), absurd));
}

TEST(Folder, TimesAsASpreadsheetWritesThemAreRead) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 2);
  put(folder.path("rec/timestamps.csv"), "\xEF\xBB\xBF\"frame\";\"host_ns\";\r\n0;1000;\r\n1;2000;\r\n");
  auto source = FolderSource::open(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kMadeWidth, kMadeHeight);
  EXPECT_EQ((*source)->next(out.image(), 0)->host_ns, 1000);
  EXPECT_EQ((*source)->next(out.image(), 0)->host_ns, 2000);
}

TEST(FolderWriter, RefusesAFolderThatHoldsFramesAndOneItCannotMake) {
  const TestFolder folder;
  make_folder(folder.path("rec"));
  const auto again = FolderWriter::create(folder.path("rec"), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_FALSE(again);
  EXPECT_TRUE(contains(again.error().message, "already holds frames")) << again.error().message;
  put(folder.path("file"), "a file, not a folder");
  const auto blocked = FolderWriter::create(folder.path("file/rec"), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_FALSE(blocked);
  EXPECT_TRUE(contains(blocked.error().message, folder.path("file/rec"))) << blocked.error().message;
  EXPECT_FALSE(FolderWriter::create("/proc/im2fit", camera_of(kMadeWidth, kMadeHeight), {}));
}

// The file-size limit stands in for a full disk: write() fails midway through a file all the same.
TEST(FolderWriter, AFullDiskGivesOneLineAndLeavesNoHalfFrame) {
  const TestFolder folder;
  FolderWriter::Options options;
  options.format = DepthFormat::pgm;
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kMadeWidth, kMadeHeight), options);
  ASSERT_TRUE(writer);
  const Picture frame = random_picture(kMadeWidth, kMadeHeight, 1);
  rlimit was{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &was), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, was.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto status = (*writer)->write(frame.view(), FrameInfo{});
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &was), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::io);
  EXPECT_TRUE(contains(status.error().message, "000000.pgm")) << status.error().message;
  EXPECT_TRUE(contains(status.error().message, "free some space")) << status.error().message;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("rec")))
    EXPECT_EQ(entry.path().filename(), "camera.yaml");
}

}  // namespace
}  // namespace im2fit::hal
