// SPDX-License-Identifier: Apache-2.0
// poses.csv and confidence/ of a depth folder.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "hal/folder/pose_rows.h"
#include "hal/open/open.h"
#include "made_folder.h"
#include "small_png.h"

namespace im2fit::hal {
namespace {

const char* const kHeader = "sequence,x_m,y_m,z_m,qx,qy,qz,qw\n";

struct Replay {
  std::vector<FrameInfo> frames;
  std::vector<std::vector<std::uint16_t>> pixels;
  std::vector<std::string> errors;
};

Replay replay(Source& source) {
  Replay out;
  Picture picture(source.info().intrinsics.width, source.info().intrinsics.height);
  for (;;) {
    const auto frame = source.next(picture.image(), 0);
    if (!frame && frame.error().code == ErrorCode::end_of_stream) return out;
    if (!frame) {
      out.errors.push_back(frame.error().message);
      continue;
    }
    out.frames.push_back(*frame);
    out.pixels.push_back(picture.pixels);
  }
}

TEST(FolderPoses, EachFrameHasThePoseOfItsRowAndNoneWithoutARow) {
  const TestFolder folder;
  make_folder(folder.path("rec"));
  put(folder.path("rec/poses.csv"), std::string(kHeader) +
                                        "0,0,0,0,0,0,0,1\n"
                                        "1, 0.5, -1.25, 3e-1, 0.6, 0, 0, 0.8\n"
                                        "3,1,2,3,0,-0.6,0.8,0\n");
  auto source = open_source(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  const Replay seen = replay(**source);
  ASSERT_EQ(seen.frames.size(), 4U);
  ASSERT_TRUE(seen.frames[0].pose && seen.frames[1].pose && seen.frames[3].pose);
  EXPECT_FALSE(seen.frames[2].pose);
  EXPECT_EQ(seen.frames[0].pose->w, 1);
  const CameraPose pose = *seen.frames[1].pose;
  EXPECT_EQ(pose.x, 0.6F);
  EXPECT_EQ(pose.w, 0.8F);
  EXPECT_EQ(pose.position_mm.x, 500);
  EXPECT_EQ(pose.position_mm.y, -1250);
  EXPECT_EQ(pose.position_mm.z, 300);
  EXPECT_EQ(seen.frames[3].pose->y, -0.6F);
  EXPECT_EQ(seen.pixels[1], random_picture(kMadeWidth, kMadeHeight, 1).pixels);
}

// As FrameInfo::pose of every other source: the world's axes turn along with the picture.
TEST(FolderPoses, APoseIsTurnedWithItsPicture) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 1);
  put(folder.path("rec/poses.csv"), std::string(kHeader) + "0,1,2,3,0.1,0.5,0.5,0.7\n");
  for (const int turned : {90, 180, 270}) {
    OpenOptions options;
    options.rotate_deg = turned;
    auto source = open_source(folder.path("rec"), options);
    ASSERT_TRUE(source) << source.error().message;
    const Replay seen = replay(**source);
    ASSERT_EQ(seen.frames.size(), 1U);
    const CameraPose expected = rotate_upright(CameraPose{0.1F, 0.5F, 0.5F, 0.7F, {1000, 2000, 3000}}, turned);
    EXPECT_EQ(seen.frames[0].pose->x, expected.x);
    EXPECT_EQ(seen.frames[0].pose->y, expected.y);
    EXPECT_EQ(seen.frames[0].pose->z, expected.z);
    EXPECT_EQ(seen.frames[0].pose->w, expected.w);
    EXPECT_EQ(seen.frames[0].pose->position_mm.x, expected.position_mm.x);
    EXPECT_EQ(seen.frames[0].pose->position_mm.y, expected.position_mm.y);
  }
}

TEST(FolderPoses, AQuaternionNearOneIsNormalisedAndAPieceOfARowAtTheEndIsIgnored) {
  const TestFolder folder;
  make_folder(folder.path("rec"));
  put(folder.path("rec/poses.csv"), std::string(kHeader) + "0,0,0,0,0,0,0,1.005\n1,0,0,0,0.70");
  auto source = open_source(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  const Replay seen = replay(**source);
  ASSERT_TRUE(seen.frames[0].pose);
  EXPECT_EQ(seen.frames[0].pose->w, 1);
  EXPECT_FALSE(seen.frames[1].pose);
}

TEST(FolderPoses, EveryBadTableIsRefusedWithOneLineNamingFileAndLine) {
  const std::string good = "0,0,0,0,0,0,0,1\n";
  const std::pair<std::string, const char*> kCases[] = {
      {"", "poses.csv line 1: there is no column sequence"},
      {good, "poses.csv line 1: there is no column sequence"},
      {"sequence,x_m,y_m,z_m,qx,qy,qz\n", "poses.csv line 1: there is no column qw"},
      {kHeader + good + "1,0,far,0,0,0,0,1\n", "poses.csv line 3: y_m is missing or not a number"},
      {kHeader + good + "1,0,nan,0,0,0,0,1\n", "poses.csv line 3: y_m is missing or not a number"},
      {kHeader + good + "1,0,0,0,0,0,0\n", "poses.csv line 3: qw is missing or not a number"},
      {kHeader + good + "1,0,0,0,0,0,0,1.02\n", "poses.csv line 3: qx, qy, qz, qw have the length 1.02"},
      {kHeader + good + "1,0,0,0,0,0,0,0\n", "poses.csv line 3: qx, qy, qz, qw have the length 0.0"},
      {kHeader + good + good, "poses.csv line 3: sequence is 0, not after 0 of the row before"},
      {kHeader + std::string("-1,0,0,0,0,0,0,1\n"), "poses.csv line 2: sequence is missing or not a whole number"},
      {kHeader + std::string("0,1e9,0,0,0,0,0,1\n"), "poses.csv line 2: x_m is over a kilometre away"},
      {kHeader + std::string("0,1e999,0,0,0,0,0,1\n"), "poses.csv line 2: x_m"},
      {kHeader + good + "1,\"0,0,0,0,0,0,1\n", "poses.csv line 3"}};
  for (const auto& [text, words] : kCases) {
    const TestFolder folder;
    make_folder(folder.path("rec"));
    put(folder.path("rec/poses.csv"), text);
    const auto source = open_source(folder.path("rec"));
    ASSERT_FALSE(source) << words;
    EXPECT_EQ(source.error().code, ErrorCode::corrupt) << words;
    EXPECT_TRUE(contains(source.error().message, words)) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, "delete the file")) << source.error().message;
    EXPECT_FALSE(contains(source.error().message, "\n")) << source.error().message;
  }
}

TEST(FolderPoses, TooManyRowsAreRefused) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 1);
  std::string text = kHeader;
  for (int i = 0; i <= 1'000'000; ++i) text += std::to_string(i) + ",0,0,0,0,0,0,1\n";
  put(folder.path("rec/poses.csv"), text);
  const auto source = open_source(folder.path("rec"));
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::unsupported);
  EXPECT_TRUE(contains(source.error().message, "poses.csv line 1000002: there are more than 1000000 rows"))
      << source.error().message;
}

// Poses as a tracker tells them: any bits of a unit quaternion, any place; the second frame has none.
TEST(FolderPoses, EveryPoseWrittenComesBackToTheBit) {
  const TestFolder folder;
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_TRUE(writer);
  const Picture picture = random_picture(kMadeWidth, kMadeHeight, 1);
  Rng rng(7);
  std::vector<FrameInfo> written;
  for (std::uint64_t i = 0; i < 200; ++i) {
    FrameInfo info{10 + i, static_cast<std::int64_t>(i), -1};
    const auto value = [&] { return static_cast<float>(rng.normal()); };
    CameraPose pose{value(), value(), 1e-7F * value(), value(), {1e-6F * value(), 500 * value(), 1e5F * value()}};
    const float length = std::sqrt(pose.x * pose.x + pose.y * pose.y + pose.z * pose.z + pose.w * pose.w);
    for (float* part : {&pose.x, &pose.y, &pose.z, &pose.w}) *part /= length;
    if (i != 1) info.pose = pose;
    ASSERT_TRUE((*writer)->write(picture.view(), info));
    written.push_back(info);
  }
  ASSERT_TRUE((*writer)->finish());
  auto source = open_source(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  const Replay seen = replay(**source);
  ASSERT_EQ(seen.frames.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    ASSERT_EQ(seen.frames[i].pose.has_value(), i != 1) << i;
    if (i == 1) continue;
    const CameraPose &was = *written[i].pose, &is = *seen.frames[i].pose;
    EXPECT_EQ(is.x, was.x);
    EXPECT_EQ(is.y, was.y);
    EXPECT_EQ(is.z, was.z);
    EXPECT_EQ(is.w, was.w);
    EXPECT_EQ(is.position_mm.x, was.position_mm.x);
    EXPECT_EQ(is.position_mm.y, was.position_mm.y);
    EXPECT_EQ(is.position_mm.z, was.position_mm.z);
  }
}

TEST(FolderPoses, WithoutPosesThereIsNoTableAndAFailedFrameLeavesNone) {
  const TestFolder folder;
  make_folder(folder.path("still"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("still/poses.csv")));
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_TRUE(writer);
  const Picture picture = random_picture(kMadeWidth, kMadeHeight, 1);
  FrameInfo info{0, 1, -1};
  info.pose = CameraPose{};
  // A folder in the place of the picture: its file cannot be written.
  std::filesystem::create_directories(folder.path("rec/000000.png/full"));
  EXPECT_FALSE((*writer)->write(picture.view(), info));
  EXPECT_FALSE(std::filesystem::exists(folder.path("rec/poses.csv")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("rec/timestamps.csv")));
  std::filesystem::remove_all(folder.path("rec/000000.png"));
  ASSERT_TRUE((*writer)->write(picture.view(), info));
  std::filesystem::create_directories(folder.path("rec/000001.png/full"));
  info.sequence = 1;
  info.host_ns = 2;
  EXPECT_FALSE((*writer)->write(picture.view(), info));
  ASSERT_TRUE((*writer)->finish());
  const auto table = read_file(folder.path("rec/poses.csv"));
  ASSERT_TRUE(table);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(table->data()), table->size()),
            "sequence,x_m,y_m,z_m,qx,qy,qz,qw\n000000,0,0,0,0,0,0,1\n");
}

TEST(FolderPoses, AFolderThatHoldsPosesOrConfidenceOfOtherFramesIsNotRecordedTo) {
  const TestFolder folder;
  put(folder.path("poses.csv"), kHeader);
  const auto writer = FolderWriter::create(folder.path(), camera_of(kMadeWidth, kMadeHeight), {});
  ASSERT_FALSE(writer);
  EXPECT_TRUE(contains(writer.error().message, "already holds poses.csv")) << writer.error().message;
}

class Confidence : public testing::Test {
 protected:
  void SetUp() override {
    make_folder(folder_.path("rec"));
    std::filesystem::create_directory(folder_.path("rec/confidence"));
    for (std::size_t i = 0; i < kLevels; ++i) levels_.push_back(static_cast<std::uint8_t>(i * 7 % 5));
    for (int i = 0; i < 4; ++i) put_levels(i, kMadeWidth, kMadeHeight);
  }
  std::string path(int frame) const { return folder_.path("rec/confidence/00000" + std::to_string(frame) + ".png"); }
  void put_levels(int frame, int width, int height) {
    write_grey_png(path(frame), width, height, 8, [&](int u, int v) { return levels_[at(u, v)]; });
  }
  static std::size_t at(int u, int v) { return static_cast<std::size_t>(v * kMadeWidth + u); }
  // The frame as the folder stores it, without the pixels below `confidence_min`.
  std::vector<std::uint16_t> expected(std::uint64_t frame, int confidence_min) const {
    auto pixels = random_picture(kMadeWidth, kMadeHeight, frame).pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      if (levels_[i] < confidence_min) pixels[i] = 0;
    return pixels;
  }

  static constexpr std::size_t kLevels = std::size_t{kMadeWidth} * kMadeHeight;
  TestFolder folder_;
  std::vector<std::uint8_t> levels_;
};

TEST_F(Confidence, PixelsBelowTheThresholdHaveNoDepth) {
  for (const std::optional<int> chosen :
       {std::optional<int>(), std::optional(0), std::optional(1), std::optional(4)}) {
    std::string yaml = yaml_of(camera_of(kMadeWidth, kMadeHeight), "phone", 0);
    if (chosen) yaml += "im2fit_confidence_min: " + std::to_string(*chosen) + "\n";
    put(folder_.path("rec/camera.yaml"), yaml);
    auto source = open_source(folder_.path("rec"));
    ASSERT_TRUE(source) << source.error().message;
    const Replay seen = replay(**source);
    ASSERT_EQ(seen.pixels.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(seen.pixels[i], expected(i, chosen.value_or(2)));
  }
  EXPECT_NE(expected(0, 2), expected(0, 0));
}

TEST_F(Confidence, OneThatIsMissingOrDamagedCostsItsFrame) {
  std::filesystem::remove(path(1));
  auto bytes = read_file(path(3));
  ASSERT_TRUE(bytes);
  bytes->resize(bytes->size() / 2);
  ASSERT_TRUE(write_file_atomically(path(3), *bytes));
  auto source = open_source(folder_.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  const Replay seen = replay(**source);
  ASSERT_EQ(seen.frames.size(), 2U);
  EXPECT_EQ(seen.frames[1].sequence, 2U);
  ASSERT_EQ(seen.errors.size(), 2U);
  EXPECT_TRUE(contains(seen.errors[0], "confidence/000001.png is missing")) << seen.errors[0];
  EXPECT_TRUE(contains(seen.errors[1], "confidence/000003.png is damaged")) << seen.errors[1];
  EXPECT_EQ((*source)->stats().damaged, 2U);
}

TEST_F(Confidence, PicturesOfAnotherKindAreRefusedWithOneLine) {
  put_levels(0, kMadeWidth, kMadeHeight - 1);
  auto source = open_source(folder_.path("rec"));
  ASSERT_FALSE(source);
  EXPECT_TRUE(contains(source.error().message, "confidence/000000.png is 48x39, expected 48x40"))
      << source.error().message;
  write_grey_png(path(0), kMadeWidth, kMadeHeight, 16, [](int, int) { return 2; });
  source = open_source(folder_.path("rec"));
  ASSERT_FALSE(source);
  EXPECT_TRUE(contains(source.error().message, "confidence/000000.png is a 16-bit grey PNG, expected 8-bit grey"))
      << source.error().message;
  std::filesystem::remove(path(0));
  source = open_source(folder_.path("rec"));
  ASSERT_FALSE(source);
  EXPECT_TRUE(contains(source.error().message, "confidence/000000.png is missing; ")) << source.error().message;
  put(folder_.path("rec/camera.yaml"),
      yaml_of(camera_of(kMadeWidth, kMadeHeight), "phone", 0) + "im2fit_confidence_min: 256\n");
  source = open_source(folder_.path("rec"));
  ASSERT_FALSE(source);
  EXPECT_TRUE(
      contains(source.error().message, "im2fit_confidence_min is missing or not a whole number from 0 to 255"))
      << source.error().message;
}

}  // namespace
}  // namespace im2fit::hal
