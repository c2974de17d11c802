// SPDX-License-Identifier: Apache-2.0
// Depth folders no camera writes, and scenes without a person.
#include <functional>

#include "measure_run.h"

namespace im2fit {
namespace {

using test::CameraText;
using test::Picture;
using test::write_text;

constexpr int kWallMm = 2500;
constexpr int kFrames = 6;

std::vector<Picture> plain(int value_mm) {
  return std::vector<Picture>(kFrames, Picture(320, 240, value_mm));
}

void plain_folder(const std::string& folder, const CameraText& camera = {}) {
  test::write_depth_folder(folder, plain(kWallMm), camera);
}

CameraText with_focal(const char* focal_x, const char* focal_y) {
  CameraText camera;
  camera.focal_x = focal_x;
  camera.focal_y = focal_y;
  return camera;
}

// Floor (camera 1 m above it, level) and a wall at 3 m: per row the nearer of the two.
std::vector<Picture> empty_room() {
  Picture room(320, 240, 3000);
  for (int v = 121; v < 240; ++v)
    for (int u = 0; u < 320; ++u)
      room.at(u, v) = static_cast<std::uint16_t>(std::min(3000.0, 1000.0 * 287.9 / (v - 119.5)));
  return std::vector<Picture>(kFrames, room);
}

struct Case {
  const char* name;
  std::function<void(const std::string& folder)> make;
  int exit_code;
  const char* expected;  // a part of the line on stderr: the file, key or code that is wrong
  std::vector<std::string> more = {};
};

std::ostream& operator<<(std::ostream& out, const Case& bad) {
  return out << bad.name;
}

const Case kCases[] = {
    {"FolderIsAbsent", [](const std::string&) {}, 1, "does not exist"},
    {"FolderIsEmpty", [](const std::string& f) { std::filesystem::create_directory(f); }, 1, "no depth frames"},
    {"SourceIsATextFile", [](const std::string& f) { write_text(f, "hello\n"); }, 1, "neither a folder"},
    {"OnlyCameraYaml",
     [](const std::string& f) {
       std::filesystem::create_directory(f);
       write_text(f + "/camera.yaml", test::camera_yaml({}));
     },
     1, "no depth frames"},
    {"FrameIs8BitPng",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.png", test::png(Picture(320, 240, 200), 8));
     },
     1, "000006.png"},
    {"FrameIs8BitPgm",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.pgm", test::pgm(Picture(320, 240, 200), 255));
     },
     1, "000006.pgm"},
    {"FrameIsEmpty",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000003.pgm", "");
     },
     3, "NO_PERSON"},
    {"FrameIsText",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.png", "hello\n");
     },
     3, "NO_PERSON"},
    {"FrameIsAFolder",
     [](const std::string& f) {
       plain_folder(f);
       std::filesystem::create_directory(f + "/000006.pgm");
     },
     1, "000006.pgm"},
    {"PngCutInItsHeader",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.png", test::png(Picture(320, 240, kWallMm)).substr(0, 20));
     },
     3, "NO_PERSON"},
    {"FramesOfDifferentSizes",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.pgm", test::pgm(Picture(160, 120, kWallMm)));
     },
     1, "160x120"},
    {"SizeInTheHeaderIsAbsurd",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.pgm", "P5\n2000000000 2000000000\n65535\n");
     },
     1, "000006.pgm"},
    // 128 MB of pixels would follow: it is refused by its header.
    {"FramesOf8192Squared",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000006.pgm", "P5\n8192 8192\n65535\n" + std::string(1000, '\x07'));
     },
     1, "8192x8192"},
    {"FramesOfOnePixel",
     [](const std::string& f) {
       test::write_depth_folder(
           f, std::vector<Picture>(kFrames, Picture(1, 1, kWallMm)),
           {.width = 1, .height = 1, .focal_x = "1", .focal_y = "1", .centre_x = 0, .centre_y = 0});
     },
     3, "NO_PERSON"},
    {"TimesJumpByAYear",
     [](const std::string& f) {
       plain_folder(f);
       write_text(
           f + "/timestamps.csv",
           "frame,host_ns\n0,0\n1,33000000\n2,66000000\n3,31536000000000000\n4,31536000033000000\n5,3153600006600"
           "0000\n");
     },
     3, "NO_PERSON"},
    {"TwoFramesOfOneNumber",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/000003.png", test::png(Picture(320, 240, kWallMm)));
     },
     1, "same frame number"},
    {"CameraYamlIsMissing",
     [](const std::string& f) {
       plain_folder(f);
       std::filesystem::remove(f + "/camera.yaml");
     },
     1, "camera.yaml is missing"},
    {"CameraYamlGivenIsMissing",
     [](const std::string& f) { plain_folder(f); },
     1,
     "/no/such.yaml",
     {"--camera", "/no/such.yaml"}},
    {"SizeChartIsMissing",
     [](const std::string& f) { plain_folder(f); },
     1,
     "/no/such.csv",
     {"--size-chart", "/no/such.csv"}},
    {"TruthGivenIsADevice", [](const std::string& f) { plain_folder(f); }, 1, "/dev/null", {"--truth", "/dev/null"}},
    {"CameraYamlIsEmpty",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/camera.yaml", "");
     },
     1, "camera.yaml"},
    {"CameraYamlIsBinary",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/camera.yaml", std::string("\x00\x01\xFF{[", 5));
     },
     1, "camera.yaml"},
    {"CameraYamlIsAFolder",
     [](const std::string& f) {
       plain_folder(f);
       std::filesystem::remove(f + "/camera.yaml");
       std::filesystem::create_directory(f + "/camera.yaml");
     },
     1, "camera.yaml"},
    {"FocalLengthIsZero", [](const std::string& f) { plain_folder(f, with_focal("0", "0")); }, 1, "focal length fx"},
    {"FocalLengthIsNan", [](const std::string& f) { plain_folder(f, with_focal("287.9", ".nan")); }, 1,
     "focal length fy"},
    {"FocalLengthIsInfinite", [](const std::string& f) { plain_folder(f, with_focal(".inf", "287.9")); }, 1,
     "focal length fx"},
    {"FocalLengthIsNegative", [](const std::string& f) { plain_folder(f, with_focal("-287.9", "287.9")); }, 1,
     "focal length fx"},
    {"FocalLengthIsAWord", [](const std::string& f) { plain_folder(f, with_focal("wide", "287.9")); }, 1,
     "camera.yaml"},
    {"PictureHasNoWidth", [](const std::string& f) { plain_folder(f, {.width = 0}); }, 1, "0x240"},
    {"CentreIsOutside", [](const std::string& f) { plain_folder(f, {.centre_x = 4000}); }, 1, "cx"},
    {"RotationIsCrooked", [](const std::string& f) { plain_folder(f, {.rotate_deg = 45}); }, 1, "im2fit_rotate_deg"},
    {"TimesGoBack",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/timestamps.csv", "frame,host_ns\n0,100\n1,200\n2,150\n3,300\n4,400\n5,500\n");
     },
     1, "timestamps.csv line 4"},
    {"TimesStandStill",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/timestamps.csv", "frame,device_us\n0,100\n1,100\n");
     },
     1, "timestamps.csv line 3"},
    {"TimesAreNoNumbers",
     [](const std::string& f) {
       plain_folder(f);
       write_text(f + "/timestamps.csv", "frame,host_ns\n0,now\n");
     },
     1, "timestamps.csv line 2"},
    {"EveryPngIsCutInItsPixels",
     [](const std::string& f) {
       std::filesystem::create_directory(f);
       write_text(f + "/camera.yaml", test::camera_yaml({}));
       const std::string whole = test::png(Picture(320, 240, kWallMm));
       for (int i = 0; i < kFrames; ++i)
         write_text(f + "/" + test::frame_name(i, "png"), whole.substr(0, whole.size() / 2));
     },
     1, "00000"},
    {"EveryPgmIsCutInItsPixels",
     [](const std::string& f) {
       plain_folder(f);
       for (int i = 0; i < kFrames; ++i) std::filesystem::resize_file(f + "/" + test::frame_name(i, "pgm"), 50'000);
     },
     1, "00000"},
    // One damaged picture among good ones is left out, as a camera's would be.
    {"OnePngIsCutInItsPixels",
     [](const std::string& f) {
       plain_folder(f);
       const std::string whole = test::png(Picture(320, 240, kWallMm));
       write_text(f + "/000006.png", whole.substr(0, whole.size() / 2));
     },
     3, "NO_PERSON"},
    {"OneFrameOnly", [](const std::string& f) { test::write_depth_folder(f, {Picture(320, 240, kWallMm)}); }, 3,
     "NO_PERSON"},
    {"AllZero", [](const std::string& f) { test::write_depth_folder(f, plain(0)); }, 3, "NO_PERSON"},
    {"AllLargest", [](const std::string& f) { test::write_depth_folder(f, plain(65535)); }, 3, "NO_PERSON"},
    {"WallOnly", [](const std::string& f) { plain_folder(f); }, 3, "NO_PERSON"},
    {"WallBeforeTheNose", [](const std::string& f) { test::write_depth_folder(f, plain(1)); }, 3, "NO_PERSON"},
    {"FloorAndWall", [](const std::string& f) { test::write_depth_folder(f, empty_room()); }, 3, "NO_PERSON"},
    {"OnePixel",
     [](const std::string& f) {
       test::write_depth_folder(f, std::vector<Picture>(kFrames, Picture(1, 1, kWallMm)), {1, 1, "1", "1", 0, 0, 0});
     },
     3, "NO_PERSON"},
};

class BadFolder : public testing::TestWithParam<Case> {};

TEST_P(BadFolder, IsAnsweredWithOneLineOrGuidance) {
  IM2FIT_NEED_DATA();
  const Case& bad = GetParam();
  const test::TestFolder folder;
  bad.make(folder.path("depth"));
  const test::Run run = test::measure(folder.path("depth"), folder.path("out"), bad.more);
  EXPECT_EQ(run.exit_code, bad.exit_code) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr(bad.expected));
  test::expect_honest(run, folder.path("out"));
  if (bad.exit_code == 1) {
    EXPECT_THAT(test::files_in(folder.path("out")), testing::IsEmpty());
  } else {
    EXPECT_THAT(test::guidance_in(folder.path("out")), testing::Contains(bad.expected));
  }
}

// A dataset's own truth.json stopped everything with "key 'schema' not found".
TEST(BadTruth, AskedForItMustBeOneAndBesideTheFramesItIsNotNeeded) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  plain_folder(folder.path("depth"));
  for (const char* text : {"{", R"({"label": "cat"})"}) {
    write_text(folder.path("depth") + "/truth.json", text);
    const test::Run beside = test::measure(folder.path("depth"), folder.path("out"), {});
    EXPECT_EQ(beside.exit_code, 3);
    EXPECT_THAT(beside.err, testing::HasSubstr("continuing without it"));
  }
  const test::Run asked =
      test::measure(folder.path("depth"), folder.path("out2"), {"--truth", folder.path("depth") + "/truth.json"});
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.err, testing::HasSubstr("is not the truth of a rendered person"));
  EXPECT_EQ(test::measure(folder.path("depth"), folder.path("out3"), {"--truth", "/no/such.json"}).exit_code, 1);
}

// All damaged frames are left out, counted and reported.
TEST(DamagedFrames, AreCountedOnStderrAndInTheResult) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string f = folder.path("depth");
  plain_folder(f);
  const std::string whole = test::png(Picture(320, 240, kWallMm));
  std::string bad_sum = whole;
  bad_sum[bad_sum.size() / 2] = static_cast<char>(bad_sum[bad_sum.size() / 2] ^ 0x55);
  write_text(f + "/000006.png", whole.substr(0, whole.size() / 2));
  write_text(f + "/000007.png", bad_sum);
  write_text(f + "/000008.png", "");
  write_text(f + "/000009.png", "no picture");
  const test::Run run = test::measure(f, folder.path("out"), {});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr("4 damaged frames were left out: "));
  EXPECT_THAT(run.err, testing::HasSubstr("000006.png"));
  const auto result = nlohmann::json::parse(test::read_text(folder.path("out") + "/result.json"));
  EXPECT_EQ(result["frames"]["damaged"], 4);
  EXPECT_EQ(result["frames"]["seen"], kFrames);
}

INSTANTIATE_TEST_SUITE_P(Table, BadFolder, testing::ValuesIn(kCases),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace im2fit
