// SPDX-License-Identifier: Apache-2.0
// Rosbags, written by the library of ROS (write_bag.py).
#include "hal/recording/bag_recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "hal/open/open.h"
#include "hal/recording/frame_times.h"
#include "made_folder.h"
#include "other_programs.h"

namespace im2fit::hal {
namespace {

constexpr int kFrames = 5;

class BagRecording : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }

  void SetUp() override {
    if (!run_in(folder_.path(), "/usr/bin/python3 -c 'import rosbag, sensor_msgs.msg'"))
      GTEST_SKIP() << "no rosbag for Python: scripts/deps test";
    std::ofstream raw(path("raw"), std::ios::binary);
    for (int i = 0; i < kFrames; ++i) append_big_endian(raw, frame(i).view());
  }
  static Picture frame(int i) { return random_picture(kMadeWidth, kMadeHeight, static_cast<std::uint64_t>(i)); }

  bool write(const std::string& name, const std::string& kind, const std::string& compression = "none") const {
    return run_in(folder_.path(),
                  "/usr/bin/python3 " IM2FIT_HAL_TESTS "/write_bag.py " + name + " " + kind + " " + compression);
  }

  // The bits of a depth folder of the same frames with the calibration `calibration`.
  void expect_frames(const std::string& name, const Calibration& calibration, double unit_mm = 1) {
    const std::string made = path("frames");
    std::filesystem::remove_all(made);
    auto writer = FolderWriter::create(made, calibration.intrinsics, {});
    ASSERT_TRUE(writer) << writer.error().message;
    for (int i = 0; i < kFrames; ++i)
      ASSERT_TRUE((*writer)->write(frame(i).view(), FrameInfo{static_cast<std::uint64_t>(i)}));
    ASSERT_TRUE((*writer)->finish());
    put(made + "/camera.yaml", camera_yaml_text(calibration, "camera"));
    OpenOptions options;
    options.unit_mm = unit_mm;
    auto folder = open_source(made, options);
    ASSERT_TRUE(folder) << folder.error().message;
    auto source = open_source(path(name));
    ASSERT_TRUE(source) << source.error().message;
    const Intrinsics k = (*source)->info().intrinsics;
    EXPECT_EQ(k.fx, calibration.intrinsics.fx);
    EXPECT_EQ(k.fy, calibration.intrinsics.fy);
    EXPECT_EQ(k.cx, calibration.intrinsics.cx);
    EXPECT_EQ(k.cy, calibration.intrinsics.cy);
    EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::recording);
    EXPECT_EQ((*source)->info().frame_count, kFrames);
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE((*source)->start());
      ASSERT_TRUE((*folder)->start());
      Picture out(kMadeWidth, kMadeHeight), expected(kMadeWidth, kMadeHeight);
      for (int i = 0; i < kFrames; ++i) {
        const auto got = (*source)->next(out.image(), 0);
        ASSERT_TRUE(got) << got.error().message;
        ASSERT_TRUE((*folder)->next(expected.image(), 0));
        EXPECT_EQ(out.pixels, expected.pixels) << i;
        EXPECT_EQ(got->host_ns, 100'000'000'000 + std::int64_t{33333333} * i);
        EXPECT_EQ(got->device_us, 50'000'000 + i);
      }
      EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
    }
  }
  static Calibration plain() {
    Calibration calibration;
    calibration.intrinsics = {kMadeWidth, kMadeHeight, 43.25F, 43.5F, 20.5F, 21.25F};
    return calibration;
  }

  std::string refused(const std::string& name, const OpenOptions& options = {}) const {
    const auto source = open_source(path(name), options);
    EXPECT_FALSE(source);
    if (source) return "";
    EXPECT_FALSE(contains(source.error().message, "\n")) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, name)) << source.error().message;
    return source.error().message;
  }

  TestFolder folder_;
};

TEST_F(BagRecording, RealSensesTopicsHaveTheFoldersBits) {
  ASSERT_TRUE(write("a.bag", "realsense"));
  expect_frames("a.bag", plain());
  ASSERT_TRUE(write("fine.bag", "units"));
  expect_frames("fine.bag", plain(), 0.1);
}

TEST_F(BagRecording, CompressedChunksHaveThemToo) {
  for (const char* name : {"bz2", "lz4"}) {
    const std::string compression = name;
    ASSERT_TRUE(write("a.bag", "realsense", compression));
    if (compression == "bz2" ? IM2FIT_HAVE_BZIP2 : IM2FIT_HAVE_LZ4)
      expect_frames("a.bag", plain());
    else
      EXPECT_TRUE(contains(refused("a.bag"), "and this build has no lib" + compression)) << refused("a.bag");
  }
}

TEST_F(BagRecording, RosTopicsHaveTheirLensByteOrderAndPadding) {
  ASSERT_TRUE(write("a.bag", "ros"));
  Calibration bent = plain();
  bent.distortion.coefficients = {0.1, -0.05, 0.001, 0.002, 0.01};
  expect_frames("a.bag", bent);
}

TEST_F(BagRecording, MetresOfRectifiedPicturesHaveTheProjectionsLens) {
  ASSERT_TRUE(write("a.bag", "metres"));
  Calibration rectified = plain();
  rectified.intrinsics = {kMadeWidth, kMadeHeight, 40, 40, 20, 21};
  expect_frames("a.bag", rectified);
  ASSERT_TRUE(write("fisheye.bag", "undone"));
  expect_frames("fisheye.bag", rectified);
}

TEST_F(BagRecording, ATopicMayHaveSeveralWriters) {
  ASSERT_TRUE(write("a.bag", "again"));
  expect_frames("a.bag", plain());
}

TEST_F(BagRecording, WhatIsMissingOrAmbiguousIsNamed) {
  ASSERT_TRUE(write("blind.bag", "blind"));
  EXPECT_TRUE(contains(refused("blind.bag"), "has no /camera/depth/camera_info")) << refused("blind.bag");
  OpenOptions options;
  options.camera_yaml_path = path("camera.yaml");
  put(options.camera_yaml_path, camera_yaml_text(plain(), "x"));
  const auto given = open_source(path("blind.bag"), options);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_EQ((*given)->info().intrinsics.fx, 43.25F);
  put(options.camera_yaml_path, yaml_of(camera_of(640, 480), "x", 0));
  EXPECT_TRUE(contains(refused("blind.bag", options), "is for 640x480"));
  const std::pair<const char*, const char*> kKinds[] = {
      {"two", "several topics of depth (/left/depth/image_raw, /right/depth/image_raw)"},
      {"colour", "no topic of depth pictures (pictures: /camera/color/image_raw)"},
      {"bytes", "pictures of 8UC1, expected mono16, 16UC1 or 32FC1"},
      {"packed", "compressed depth pictures alone"},
      {"fisheye", "(/camera/depth/camera_info): distortion_model is equidistant"}};
  for (const auto& [kind, words] : kKinds) {
    ASSERT_TRUE(write(std::string(kind) + ".bag", kind));
    EXPECT_TRUE(contains(refused(std::string(kind) + ".bag"), words)) << refused(std::string(kind) + ".bag");
  }
}

TEST_F(BagRecording, OtherFilesAndOnesCutOffAreRefusedInOneLine) {
  put(path("empty.bag"), "");
  EXPECT_TRUE(contains(refused("empty.bag"), "is not a rosbag of ROS 1"));
  put(path("text.bag"), "hello, this is a bag of words");
  EXPECT_TRUE(contains(refused("text.bag"), "is not a rosbag of ROS 1"));
  put(path("old.bag"), "#ROSBAG V1.2\nanything");
  EXPECT_TRUE(contains(refused("old.bag"), "format 1"));
  ASSERT_TRUE(write("whole.bag", "realsense"));
  const auto whole = read_file(path("whole.bag"));
  ASSERT_TRUE(whole);
  // Its index is the last 2 kB or so: cut within it, topics are there.
  for (std::size_t size = 13; size + 4000 < whole->size(); size += size < 6000 ? 13 : 1009) {
    const auto source = open_bag_recording(FileCursor(std::span(*whole).first(size), "cut.bag"), {});
    ASSERT_FALSE(source) << size;
    EXPECT_TRUE(contains(source.error().message, "cut.bag has no index: it was cut off")) << source.error().message;
  }
}

#if IM2FIT_HAVE_LZ4
TEST_F(BagRecording, ADamagedChunkIsPassedOver) {
  ASSERT_TRUE(write("a.bag", "metres", "lz4"));
  auto bytes = read_file(path("a.bag"));
  ASSERT_TRUE(bytes);
  // The first chunk with pictures behind the one that the head is read from.
  const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  std::size_t at = 0;
  for (int i = 0; i < 3; ++i) at = text.find("compression=lz4", at + 1);
  ASSERT_NE(at, std::string::npos);
  for (std::size_t i = at + 60; i < at + 90; ++i) (*bytes)[i] = std::byte{0xFF};
  auto source = open_bag_recording(FileCursor(std::span(*bytes), "a.bag"), {});
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kMadeWidth, kMadeHeight);
  int good = 0, damaged = 0;
  for (int calls = 0; calls < 20; ++calls) {
    const auto got = (*source)->next(out.image(), 0);
    good += got ? 1 : 0;
    if (got) continue;
    if (got.error().code == ErrorCode::end_of_stream) break;
    ++damaged;
    EXPECT_EQ(got.error().code, ErrorCode::corrupt);
    EXPECT_FALSE(contains(got.error().message, "\n"));
  }
  EXPECT_EQ(damaged, 1);
  EXPECT_EQ(good, kFrames - 1);
}
#endif

TEST_F(BagRecording, CompressedChunksHaveALimit) {
  ASSERT_TRUE(write("a.bag", "ros", "bz2"));
  auto bytes = read_file(path("a.bag"));
  ASSERT_TRUE(bytes);
  const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const std::string_view size("\x09\0\0\0size=", 9);
  std::size_t at = text.find(size);
  ASSERT_NE(at, std::string::npos);
  for (; at != std::string::npos; at = text.find(size, at + 1)) (*bytes)[at + 12] = std::byte{0x50};
  const auto source = open_bag_recording(FileCursor(std::span(*bytes), "a.bag"), {});
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::unsupported);
  EXPECT_TRUE(contains(source.error().message, "expected at most 67108864; write it plain by: rosbag decompress"))
      << source.error().message;
}

// Wherever the file ends all at once: in a record's head, a message's head, or pixels.
TEST_F(BagRecording, AFailingReadIsNoDamage) {
  ASSERT_TRUE(write("whole.bag", "metres"));
  const auto whole = read_file(path("whole.bag"));
  ASSERT_TRUE(whole);
  Picture out(kMadeWidth, kMadeHeight);
  int failed = 0;
  for (std::size_t size = 6000; size < whole->size() * 3 / 4; size += 301) {
    ASSERT_TRUE(write_file_atomically(path("a.bag"), std::span<const std::byte>(*whole)));
    auto source = open_source(path("a.bag"));
    ASSERT_TRUE(source) << source.error().message;
    std::filesystem::resize_file(path("a.bag"), size);
    auto got = (*source)->next(out.image(), 0);
    for (int i = 1; got && i < kFrames; ++i) got = (*source)->next(out.image(), 0);
    ASSERT_FALSE(got) << size;
    EXPECT_EQ(got.error().code, ErrorCode::io) << size << ": " << got.error().message;
    EXPECT_TRUE(contains(got.error().message, "became shorter while it was read")) << got.error().message;
    EXPECT_EQ((*source)->stats().damaged, 0U);
    ++failed;
  }
  EXPECT_GT(failed, 20);
}

TEST_F(BagRecording, AWrongTimeCostsOneFrame) {
  for (const char* kind : {"jump", "back"}) {
    ASSERT_TRUE(write("a.bag", kind));
    auto source = open_source(path("a.bag"));
    ASSERT_TRUE(source) << source.error().message;
    Picture out(kMadeWidth, kMadeHeight);
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE((*source)->start());
      for (int i = 0; i < kFrames; ++i) {
        const auto got = (*source)->next(out.image(), 0);
        ASSERT_EQ(static_cast<bool>(got), i != 2) << kind << i;
        if (i == 2) {
          EXPECT_EQ(got.error().code, ErrorCode::corrupt);
          EXPECT_TRUE(contains(got.error().message, "frame 2 has a time that is not within 10 s")) << kind;
          continue;
        }
        EXPECT_EQ(out.pixels, frame(i).pixels);
        // A clock that was set back goes on from where it was.
        const int steps = std::string(kind) == "back" && i > 2 ? i - 1 : i;
        EXPECT_EQ(got->host_ns, 100'000'000'000 + std::int64_t{33333333} * steps) << kind << i;
      }
      EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
    }
  }
}

// As recorded, in s; the same list, of what is given, with -1 for a frame that is refused.
TEST(FrameTimes, AreRefusedOnceAndLaterThanTheOnesBefore) {
  using Seconds = std::vector<std::int64_t>;
  const std::pair<Seconds, Seconds> table[] = {
      {{0, 1, 2, 12, 13}, {0, 1, 2, 12, 13}},
      {{5, 6, 900, 8, 9}, {5, 6, -1, 8, 9}},
      {{5, 6, 900, 901, 902}, {5, 6, -1, 901, 902}},  // paused
      {{5, 6, 6, 7}, {5, 6, -1, 7}},                  // twice the same
      {{1000, 1001, 1, 2, 3}, {1000, 1001, -1, 1002, 1003}},
      {{1000, 1001, 1, 500, 501}, {1000, 1001, -1, 1011, 1012}},
      {{4'100'000'000, 1, 2, 4}, {-1, 1, 2, 4}},  // after the year 2096
      {{3'900'000'000, 1, 2, 4}, {3'900'000'000, -1, 3'900'000'001, 3'900'000'003}},
      {{3'900'000'000, 1, 2, 3'900'000'000, 3'900'000'001, 1, 2},
       {3'900'000'000, -1, 3'900'000'001, -1, 3'900'000'002, -1, 3'900'000'003}}};
  for (const auto& [recorded, expected] : table) {
    FrameTimes times;
    for (int round = 0; round < 2; ++round) {
      Seconds given;
      for (const std::int64_t s : recorded) {
        const auto time_ns = times.take(s * 1'000'000'000);
        given.push_back(time_ns ? *time_ns / 1'000'000'000 : -1);
      }
      EXPECT_EQ(given, expected);
      times.restart();
    }
  }
}

// One byte at a time.
TEST_F(BagRecording, AChangedByteGivesFramesOrOneLine) {
  ASSERT_TRUE(write("whole.bag", "ros"));
  const auto whole = read_file(path("whole.bag"));
  ASSERT_TRUE(whole);
  for (std::size_t at = 0; at < whole->size(); at += at < 4300 ? 11 : 307) {
    auto bytes = *whole;
    bytes[at] ^= std::byte{0xFF};
    auto source = open_bag_recording(FileCursor(std::span(bytes), "changed.bag"), {});
    if (!source) {
      EXPECT_FALSE(contains(source.error().message, "\n")) << at;
      continue;
    }
    const Intrinsics k = (*source)->info().intrinsics;
    Picture out(k.width, k.height);
    int calls = 0;
    for (; calls < 100; ++calls) {
      const auto got = (*source)->next(out.image(), 0);
      if (!got && got.error().code == ErrorCode::end_of_stream) break;
    }
    EXPECT_LT(calls, 100) << at;
  }
}

}  // namespace
}  // namespace im2fit::hal
