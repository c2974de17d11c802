// SPDX-License-Identifier: Apache-2.0
// What the writer leaves on the disk, byte by byte and with no OpenNI2.
#include "hal/openni2/oni_writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <span>

#include "core/crc32c.h"
#include "core/file.h"
#include "hal/folder/camera_yaml.h"
#include "hard_pictures.h"

namespace im2fit::hal {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr std::uint64_t kUnknown = ~std::uint64_t{0};

struct Record {
  std::uint32_t type = 0;
  std::uint32_t node = 0;
  std::uint64_t undo_at = 0;
  std::uint64_t at = 0;
  std::span<const std::byte> fields;
  std::span<const std::byte> payload;
};

std::uint64_t number(std::span<const std::byte> bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint64_t>(bytes[at + i]) << (8 * i);
  return value;
}

// Every record up to the file's end; stops where one does not fit.
std::vector<Record> records_of(std::span<const std::byte> file) {
  std::vector<Record> records;
  for (std::size_t at = 24; at + 28 <= file.size();) {
    const auto fields = static_cast<std::size_t>(number(file, at + 12, 4));
    const auto payload = static_cast<std::size_t>(number(file, at + 16, 4));
    if (number(file, at, 4) != 0x0052494E || fields < 28 || fields + payload > file.size() - at) break;
    records.push_back({static_cast<std::uint32_t>(number(file, at + 4, 4)),
                       static_cast<std::uint32_t>(number(file, at + 8, 4)), number(file, at + 20, 8), at,
                       file.subspan(at + 28, fields - 28), file.subspan(at + fields, payload)});
    at += fields + payload;
  }
  return records;
}

std::vector<Record> of_type(const std::vector<Record>& records, std::uint32_t type) {
  std::vector<Record> chosen;
  for (const Record& record : records)
    if (record.type == type) chosen.push_back(record);
  return chosen;
}

class OniWriterTest : public testing::Test {
 protected:
  Result<std::unique_ptr<OniWriter>> create() {
    return OniWriter::create(oni_, camera_of(kWidth, kHeight), {"a camera", IntrinsicsOrigin::synthetic});
  }
  std::vector<std::byte> bytes(const std::string& path) { return read_file(path) ? *read_file(path) : Bytes{}; }
  static bool exists(const std::string& path) { return std::filesystem::exists(path); }
  using Bytes = std::vector<std::byte>;

  TestFolder folder_;
  const std::string oni_ = folder_.path("a.oni");
  const Picture picture_ = random_picture(kWidth, kHeight, 1, 3000);
};

TEST_F(OniWriterTest, AClosedFileSaysAllThereIsAndWhereToSeek) {
  auto writer = create();
  ASSERT_TRUE(writer) << writer.error().message;
  // 5, 6, 9, then a counter that starts again.
  const FrameInfo frames[] = {{5, 7, 1000}, {6, 8, 34'333}, {9, 9, 134'333}, {2, 10, 167'666}};
  for (const auto& info : frames) ASSERT_TRUE((*writer)->write(picture_.view(), info));
  EXPECT_FALSE(exists(oni_));
  EXPECT_EQ((*writer)->kept_path(), oni_ + ".part");
  ASSERT_TRUE((*writer)->finish());
  ASSERT_TRUE((*writer)->finish()) << "once more is harmless";
  EXPECT_EQ((*writer)->kept_path(), oni_);
  EXPECT_FALSE(exists(oni_ + ".part"));
  EXPECT_FALSE(exists(oni_ + ".part.yaml"));

  const Bytes file = bytes(oni_);
  EXPECT_EQ(std::memcmp(file.data(), "NI10\1\0\1\0\0\0\0\0", 12), 0);
  EXPECT_EQ(number(file, 12, 8), 167'666U) << "the latest time";
  const auto records = records_of(file);
  ASSERT_GE(records.size(), 4U);
  EXPECT_EQ(records.back().type, 0x0BU);
  EXPECT_EQ(records.back().at + 28, file.size()) << "nothing behind the end";
  const auto& node = records.front();
  EXPECT_EQ(node.type, 0x0DU);
  EXPECT_EQ(std::memcmp(node.fields.data(), "\6\0\0\0Depth\0\2\0\0\00016zT\6\0\0\0", 22), 0) << "depth, six numbers";
  EXPECT_EQ(number(node.fields, 22, 8), 1000U);
  EXPECT_EQ(number(node.fields, 30, 8), 167'666U);

  const auto data = of_type(records, 0x0A);
  ASSERT_EQ(data.size(), 4U);
  const std::uint64_t numbers[] = {1, 2, 5, 6};
  for (std::size_t i = 0; i < data.size(); ++i) {
    EXPECT_EQ(number(data[i].fields, 0, 8), static_cast<std::uint64_t>(frames[i].device_us));
    EXPECT_EQ(number(data[i].fields, 8, 4), numbers[i]);
    EXPECT_EQ(data[i].undo_at, i == 0 ? 0 : data[i - 1].at);
    EXPECT_EQ(data[i].node, 1U);
  }
  const auto tables = of_type(records, 0x0E);
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_EQ(number(node.fields, 38, 8), tables[0].at);
  ASSERT_EQ(tables[0].payload.size(), 7 * 20U) << "an entry for each number, and one for none";
  const std::size_t found[] = {0, 1, 1, 1, 2, 3};  // a missing one leads to the frame before it
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(number(tables[0].payload, 20 * (i + 1) + 12, 8), data[found[i]].at) << i;
    EXPECT_EQ(number(tables[0].payload, 20 * (i + 1), 8), number(data[found[i]].fields, 0, 8)) << i;
  }
  const auto removed = of_type(records, 0x07);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].undo_at, node.at);
}

TEST_F(OniWriterTest, TheCalibrationBesideItKnowsTheFile) {
  auto writer = create();
  ASSERT_TRUE(writer);
  const auto open = load_camera_yaml(oni_ + ".part.yaml");
  ASSERT_TRUE(open) << open.error().message;
  EXPECT_FALSE(open->oni_crc32c) << "not while it is being written";
  ASSERT_TRUE((*writer)->write(picture_.view(), {}));
  ASSERT_TRUE((*writer)->finish());
  const auto closed = load_camera_yaml(oni_sidecar_path(oni_));
  ASSERT_TRUE(closed) << closed.error().message;
  EXPECT_EQ(closed->oni_crc32c, crc32c(bytes(oni_)));
  EXPECT_EQ(closed->origin, IntrinsicsOrigin::synthetic);
  EXPECT_EQ(closed->rotate_deg, 0) << "frames are upright";
  const Intrinsics k = camera_of(kWidth, kHeight);
  for (const auto& file : {*open, *closed}) {
    EXPECT_EQ(file.intrinsics.fx, k.fx);
    EXPECT_EQ(file.intrinsics.cx, k.cx);
    EXPECT_EQ(file.intrinsics.cy, k.cy);
  }
}

TEST_F(OniWriterTest, TimesGrowWhateverTheClockDoes) {
  const auto times = [&](const std::vector<FrameInfo>& frames) {
    std::vector<std::uint64_t> found;
    auto writer = create();
    EXPECT_TRUE(writer);
    if (!writer) return found;
    for (const auto& frame : frames) EXPECT_TRUE((*writer)->write(picture_.view(), frame));
    EXPECT_TRUE((*writer)->finish());
    const Bytes file = bytes(oni_);
    for (const auto& record : of_type(records_of(file), 0x0A)) found.push_back(number(record.fields, 0, 8));
    return found;
  };
  using Times = std::vector<std::uint64_t>;
  EXPECT_EQ(times({{0, 5'000'000, -1}, {1, 9'999'999, 77}}), (Times{5000, 9999})) << "the host's, when first used";
  EXPECT_EQ(times({{0, 0, 100}, {1, 0, 100}, {2, 0, 50}, {3, 0, 900'000}}), (Times{100, 33'433, 66'766, 900'000}));
  EXPECT_EQ(times({{0, 0, 10}, {1, 0, INT64_MAX}, {2, 0, 400'000}}), (Times{10, 33'343, 400'000}));
}

TEST_F(OniWriterTest, TheRateIsThatOfTheFrames) {
  for (const int fps : {5, 30, 60}) {
    auto writer = create();
    ASSERT_TRUE(writer);
    // Half of the frames are missing: the camera's rate is twice that of the frames that came.
    for (int i = 0; i < 20; i += 2)
      ASSERT_TRUE((*writer)->write(picture_.view(), {static_cast<std::uint64_t>(i), 0, i * 1'000'000 / fps}));
    ASSERT_TRUE((*writer)->finish());
    const Bytes file = bytes(oni_);
    int modes = 0;
    for (const auto& record : of_type(records_of(file), 0x06)) {
      if (number(record.fields, 0, 4) != sizeof "xnMapOutputMode" ||
          std::memcmp(record.fields.data() + 4, "xnMapOutputMode", sizeof "xnMapOutputMode") != 0)
        continue;
      ++modes;
      const auto mode = record.fields.subspan(4 + sizeof "xnMapOutputMode" + 4);
      EXPECT_EQ(number(mode, 0, 4), static_cast<std::uint64_t>(kWidth));
      EXPECT_EQ(number(mode, 4, 4), static_cast<std::uint64_t>(kHeight));
      EXPECT_EQ(number(mode, 8, 4), static_cast<std::uint64_t>(fps));
    }
    EXPECT_EQ(modes, 1);
  }
}

// What a kill leaves: whole records to the last frame, and numbers that are not known.
TEST_F(OniWriterTest, AnOpenFileIsWholeUpToItsLastFrame) {
  auto writer = create();
  ASSERT_TRUE(writer);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE((*writer)->write(picture_.view(), {static_cast<std::uint64_t>(i), 0, 33'333 * i}));
    const Bytes file = bytes(oni_ + ".part");
    const auto records = records_of(file);
    EXPECT_EQ(of_type(records, 0x0A).size(), static_cast<std::size_t>(i + 1));
    EXPECT_EQ(records.back().payload.data() + records.back().payload.size(), file.data() + file.size());
    EXPECT_EQ(number(file, 12, 8), kUnknown);
    EXPECT_EQ(number(records.front().fields, 18, 4), 0xFFFFFFFFU);
  }
}

TEST_F(OniWriterTest, ARecordingThatWasNeverClosedIsNotOverwritten) {
  ASSERT_TRUE(write_file_atomically(oni_ + ".part", std::string("unfinished")));
  const auto refused = create();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  EXPECT_TRUE(contains(refused.error().message, "never closed")) << refused.error().message;
  EXPECT_EQ(bytes(oni_ + ".part").size(), 10U);
  EXPECT_FALSE(exists(oni_ + ".part.yaml"));
}

TEST_F(OniWriterTest, WhatCannotBeWrittenIsRefused) {
  const auto nowhere = OniWriter::create(folder_.path("no/such/x.oni"), camera_of(kWidth, kHeight), {});
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::io);
  EXPECT_TRUE(contains(nowhere.error().message, "x.oni")) << nowhere.error().message;
  const auto large = OniWriter::create(oni_, camera_of(2048, 2048), {});
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code, ErrorCode::unsupported);
  {
    auto writer = create();
    ASSERT_TRUE(writer);
    const Picture other(kWidth, kHeight + 1);
    EXPECT_EQ((*writer)->write(other.view(), {}).error().code, ErrorCode::invalid_argument);
    const auto empty = (*writer)->finish();
    ASSERT_FALSE(empty);
    EXPECT_TRUE(contains(empty.error().message, "not one frame")) << empty.error().message;
    EXPECT_EQ((*writer)->write(picture_.view(), {}).error().code, ErrorCode::invalid_argument);
  }
  for (const char* name : {"", ".part", ".yaml", ".part.yaml"}) EXPECT_FALSE(exists(oni_ + name)) << name;
}

// The file-size limit stands in for a full disk: for every room there is, what fits is a whole recording.
class OnAFullDisk : public OniWriterTest, public testing::WithParamInterface<int> {
 protected:
  static void limit(rlim_t size) {
    rlimit now{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &now), 0);
    now.rlim_cur = size;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &now), 0);
  }
  void SetUp() override { handler_ = std::signal(SIGXFSZ, SIG_IGN); }
  void TearDown() override {
    limit(RLIM_INFINITY);
    std::signal(SIGXFSZ, handler_);
  }
  void (*handler_)(int) = nullptr;
};

TEST_P(OnAFullDisk, TheFramesBeforeAreAWholeRecording) {
  auto writer = create();
  ASSERT_TRUE(writer) << writer.error().message;
  limit(static_cast<rlim_t>(GetParam()));
  Status written = Ok{};
  std::uint64_t accepted = 0;
  for (int i = 0; i < 100 && written; ++i) {
    written = (*writer)->write(picture_.view(), {static_cast<std::uint64_t>(i), 0, 33'333 * i});
    accepted += written ? 1 : 0;
  }
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::io);
  EXPECT_TRUE(contains(written.error().message, "free some space")) << written.error().message;
  const auto finished = (*writer)->finish();
  EXPECT_EQ((*writer)->kept_path(), oni_);
  const std::uint64_t kept = (*writer)->frame_count();
  EXPECT_EQ(static_cast<bool>(finished), kept == accepted) << "a frame that made room is an error";
  EXPECT_GE(kept + 1, accepted);
  const Bytes file = bytes(oni_);
  const auto records = records_of(file);
  EXPECT_EQ(of_type(records, 0x0A).size(), kept);
  EXPECT_EQ(records.back().type, 0x0BU);
  EXPECT_EQ(records.back().at + 28, file.size());
  EXPECT_EQ(number(records.front().fields, 18, 4), kept);
  const auto beside = load_camera_yaml(oni_sidecar_path(oni_));
  ASSERT_TRUE(beside) << beside.error().message;
  EXPECT_EQ(beside->oni_crc32c, crc32c(file));
  for (const char* name : {".part", ".part.yaml"}) EXPECT_FALSE(exists(oni_ + name)) << name;
}
// More than a frame wide: in some of them the last frame fits and what closes the file does not.
INSTANTIATE_TEST_SUITE_P(Rooms, OnAFullDisk, testing::Range(49'000, 55'000, 100));

}  // namespace
}  // namespace im2fit::hal
