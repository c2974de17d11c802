// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <zlib.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <span>
#include <utility>

#include "core/file.h"
#include "hal/folder/camera_yaml.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/frame_name.h"
#include "hal/intrinsics.h"
#include "hal/open/open.h"
#include "support.h"

namespace im2fit::hal {
namespace {

constexpr int kWidth = 48;
constexpr int kHeight = 40;

void put(const std::string& path, const std::string& text) {
  ASSERT_TRUE(write_file_atomically(path, text));
}

// A good folder of `count` frames; a test then spoils one thing.
void make_folder(const std::string& path, DepthFormat format = DepthFormat::png, std::uint64_t count = 4) {
  FolderWriter::Options options;
  options.format = format;
  auto writer = FolderWriter::create(path, camera_of(kWidth, kHeight), options);
  ASSERT_TRUE(writer) << writer.error().message;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto time = static_cast<std::int64_t>(1000 + i);
    ASSERT_TRUE((*writer)->write(random_picture(kWidth, kHeight, i).view(), FrameInfo{i, time * 1000, time}));
  }
  ASSERT_TRUE((*writer)->finish());
}

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
  const Intrinsics camera = camera_of(kWidth, kHeight);
  EXPECT_EQ(info.intrinsics.fx, camera.fx);
  EXPECT_EQ(info.intrinsics.fy, camera.fy);
  EXPECT_EQ(info.intrinsics.cx, camera.cx);
  EXPECT_EQ(info.intrinsics.cy, camera.cy);
  Picture out(kWidth, kHeight);
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(out.pixels, random_picture(kWidth, kHeight, i).pixels);
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
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kWidth, kHeight), {});
  ASSERT_TRUE(writer);
  const Picture picture = random_picture(kWidth, kHeight, 1);
  const Vec3f down{0.1F, 0.99498745F, -1e-9F};
  for (std::uint64_t i = 0; i < 4; ++i) {
    FrameInfo info{i, static_cast<std::int64_t>(i), -1};
    if (i == 2) info.down = down;
    ASSERT_TRUE((*writer)->write(picture.view(), info));
  }
  ASSERT_TRUE((*writer)->finish());
  Picture out(kWidth, kHeight);
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
  put(folder.path("rec/camera.yaml"), yaml_of(camera_of(kWidth, kHeight), "turned", 90));
  EXPECT_EQ((*open_source(folder.path("rec")))->info().intrinsics.width, kHeight);
  OpenOptions options;
  options.rotate_deg = 180;
  EXPECT_EQ((*open_source(folder.path("rec"), options))->info().intrinsics.width, kWidth);
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
  Picture out(kWidth, kHeight);
  while ((*source)->next(out.image(), 0)) {
  }
  EXPECT_EQ((*source)->stats().delivered, 4U);
  EXPECT_EQ((*source)->stats().gaps, 2U);
}

TEST(Folder, GapsOfTheRecordingStayInTheNumbers) {
  const TestFolder folder;
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kWidth, kHeight), {});
  ASSERT_TRUE(writer);
  const Picture frame = random_picture(kWidth, kHeight, 1);
  for (const std::uint64_t sequence : {100U, 101U, 104U})
    ASSERT_TRUE((*writer)->write(frame.view(), FrameInfo{sequence, static_cast<std::int64_t>(sequence), -1}));
  ASSERT_TRUE((*writer)->finish());
  EXPECT_TRUE(std::filesystem::exists(folder.path("rec/000004.png")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("rec/000002.png")));
}

std::string opencv_yaml() {
  return "%YAML:1.0\n---\nimage_width: 48\nimage_height: 40\n"
         "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
         "   data: [ 4.32e+01, 0., 2.1e+01, 0., 43., 20.5, 0., 0., 1. ]\n"
         "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ 0., 0., 0., 0., 0. "
         "]\n";
}

TEST(CameraYaml, OpenCvsOwnWordingIsRead) {
  const TestFolder folder;
  put(folder.path("c.yaml"), opencv_yaml());
  const auto file = load_camera_yaml(folder.path("c.yaml"));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->intrinsics.fx, 43.2F);
  EXPECT_EQ(file->intrinsics.cy, 20.5F);
  EXPECT_FALSE(file->rotate_deg);
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

// One thing wrong each: opening must fail with one line that names the file and says what to do.
struct BadFolder {
  const char* name;
  std::function<void(const std::string&)> spoil;
  ErrorCode code;
  const char* names;  // must be in the message
};

void replace_in(const std::string& path, const std::string& from, const std::string& to) {
  const auto bytes = read_file(path);
  ASSERT_TRUE(bytes);
  std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  put(path, text.replace(at, from.size(), to));
}

// Where camera_matrix begins in the good folder's camera.yaml.
std::string yaml_fx() {
  const std::string text = yaml_of(camera_of(kWidth, kHeight), "x", 0);
  const auto begin = text.find("data: [");
  return text.substr(begin, text.find(',', begin) + 1 - begin);
}

void eight_bit_png(const std::string& path) {
  const unsigned char bytes[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n', 0, 0, 0, 13, 'I', 'H', 'D', 'R', 0,
                                 0,    0,   48,  0,   0,    0,    40,   8,    0, 0, 0, 0,  0,   0,   0,   0,   0};
  put(path, std::string(reinterpret_cast<const char*>(bytes), sizeof bytes));
}

void other_size(const std::string& path, int width, int height) {
  const Picture picture = random_picture(width, height, 1);
  ASSERT_TRUE(write_file_atomically(path, *encode_depth(picture.view(), DepthFormat::pgm)));
}

const std::vector<BadFolder>& bad_folders() {
  using F = const std::string&;
  static const std::vector<BadFolder> table = {
      {"empty", [](F f) { std::filesystem::remove_all(f), std::filesystem::create_directory(f); },
       ErrorCode::not_found, "holds no depth frames"},
      {"absent", [](F f) { std::filesystem::remove_all(f); }, ErrorCode::not_found, "does not exist"},
      {"8-bit png", [](F f) { eight_bit_png(f + "/000002.png"); }, ErrorCode::unsupported, "000002.png is a 8-bit"},
      {"8-bit pgm", [](F f) { put(f + "/000009.pgm", "P5\n48 40\n255\n" + std::string(48 * 40, 'x')); },
       ErrorCode::unsupported, "000009.pgm has maxval 255"},
      {"pictures that are none",
       [](F f) {
         for (int i = 0; i < 4; ++i) put(f + "/00000" + std::to_string(i) + ".png", "P2\n48 40\n65535\n1 2 3");
       },
       ErrorCode::corrupt, "000000.png is neither"},
      {"two sizes", [](F f) { other_size(f + "/000004.pgm", 50, 40); }, ErrorCode::invalid_argument,
       "000004.pgm is 50x40, expected 48x40"},
      {"too large", [](F f) { put(f + "/000004.pgm", "P5 4096 40 65535\n"); }, ErrorCode::unsupported, "4096x40"},
      {"number twice", [](F f) { other_size(f + "/000001.pgm", 48, 40); }, ErrorCode::invalid_argument,
       "same frame number"},
      {"no camera.yaml", [](F f) { std::filesystem::remove(f + "/camera.yaml"); }, ErrorCode::not_found,
       "camera.yaml is missing"},
      {"camera.yaml of another size", [](F f) { put(f + "/camera.yaml", yaml_of(camera_of(64, 40), "other", 0)); },
       ErrorCode::invalid_argument, "camera.yaml says 64x40"},
      {"zero focal length",
       [](F f) {
         put(f + "/camera.yaml", yaml_of({48, 40, 0, 43, 20, 20}, "zero", 0));
       },
       ErrorCode::invalid_argument, "focal length fx is 0"},
      {"NaN focal length", [](F f) { replace_in(f + "/camera.yaml", yaml_fx(), "data: [.nan,"); },
       ErrorCode::invalid_argument, "focal length fx is nan"},
      {"negative focal length", [](F f) { replace_in(f + "/camera.yaml", yaml_fx(), "data: [-43,"); },
       ErrorCode::invalid_argument, "focal length fx is -43,"},
      {"focal length in words", [](F f) { replace_in(f + "/camera.yaml", yaml_fx(), "data: [much,"); },
       ErrorCode::corrupt, "camera.yaml line"},
      {"no matrix", [](F f) { put(f + "/camera.yaml", "image_width: 48\nimage_height: 40\n"); },
       ErrorCode::invalid_argument, "camera_matrix is missing"},
      {"short matrix",
       [](F f) { put(f + "/camera.yaml", "image_width: 48\nimage_height: 40\ncamera_matrix: {data: [1, 2]}\n"); },
       ErrorCode::invalid_argument, "9 numbers"},
      {"fisheye",
       [](F f) {
         replace_in(f + "/camera.yaml", "data: [0, 0, 0, 0, 0]", "data: [0.1, 0, 0, 0, 0]");
         replace_in(f + "/camera.yaml", "plumb_bob", "equidistant");
       },
       ErrorCode::unsupported, "distortion_model is equidistant"},
      {"absurd distortion",
       [](F f) { replace_in(f + "/camera.yaml", "data: [0, 0, 0, 0, 0]", "data: [1e9, 0, 0, 0, 0]"); },
       ErrorCode::invalid_argument, "distortion_coefficients leave 0 %"},
      {"distortion that is no number",
       [](F f) { replace_in(f + "/camera.yaml", "data: [0, 0, 0, 0, 0]", "data: [.nan, 0, 0, 0, 0]"); },
       ErrorCode::invalid_argument, "distortion_coefficients"},
      {"three distortion coefficients",
       [](F f) { replace_in(f + "/camera.yaml", "data: [0, 0, 0, 0, 0]", "data: [0, 0, 1]"); },
       ErrorCode::invalid_argument, "4, 5 or 8 numbers"},
      {"no YAML", [](F f) { put(f + "/camera.yaml", "{image_width: [[[\n\"unterminated"); }, ErrorCode::corrupt,
       "camera.yaml line"},
      {"empty camera.yaml", [](F f) { put(f + "/camera.yaml", ""); }, ErrorCode::invalid_argument, "camera.yaml"},
      {"binary camera.yaml", [](F f) { put(f + "/camera.yaml", std::string("\xFF\x00\x01\xFE", 4)); },
       ErrorCode::corrupt, "camera.yaml"},
      {"crooked rotation", [](F f) { replace_in(f + "/camera.yaml", "rotate_deg: 0", "rotate_deg: 45"); },
       ErrorCode::invalid_argument, "im2fit_rotate_deg"},
      {"times go back", [](F f) { replace_in(f + "/timestamps.csv", "000002,1002000", "000002,900"); },
       ErrorCode::corrupt, "timestamps.csv line 4: host_ns is 900, not after 1001000"},
      {"a time twice", [](F f) { replace_in(f + "/timestamps.csv", ",1003\n", ",1002\n"); }, ErrorCode::corrupt,
       "timestamps.csv line 5: device_us"},
      {"times in words", [](F f) { replace_in(f + "/timestamps.csv", "1002000", "noon"); }, ErrorCode::corrupt,
       "timestamps.csv line 4"},
      {"times without names", [](F f) { put(f + "/timestamps.csv", "0,1\n1,2\n"); }, ErrorCode::corrupt,
       "timestamps.csv line 1"},
      {"a frame without time", [](F f) { replace_in(f + "/timestamps.csv", "000003,", "000033,"); },
       ErrorCode::corrupt, "has no row for"},
      {"a time past all clocks", [](F f) { put(f + "/timestamps.csv", "frame,device_us\n0,9223372036854775807\n"); },
       ErrorCode::corrupt, "timestamps.csv line 2: device_us is 9223372036854775807, expected 0 to"},
      {"a time before all clocks", [](F f) { put(f + "/timestamps.csv", "frame,host_ns\n0,-5\n"); },
       ErrorCode::corrupt, "line 2: host_ns is -5"},
      {"down in words",
       [](F f) { put(f + "/timestamps.csv", "frame,host_ns,down_x,down_y,down_z\n0,1,0,below,0\n"); },
       ErrorCode::corrupt, "timestamps.csv line 2: down_y is no number"},
      {"down too long", [](F f) { put(f + "/timestamps.csv", "frame,host_ns,down_x,down_y,down_z\n0,1,0,2,0\n"); },
       ErrorCode::corrupt, "timestamps.csv line 2: down_x, down_y, down_z are no vector of length 1"},
      {"half of down", [](F f) { put(f + "/timestamps.csv", "frame,host_ns,down_x,down_y,down_z\n0,1,,1,\n"); },
       ErrorCode::corrupt, "timestamps.csv line 2: down_x, down_y, down_z are no vector of length 1"},
      {"a number past all frames", [](F f) { std::filesystem::copy(f + "/000001.png", f + "/10000000000.png"); },
       ErrorCode::invalid_argument, "has the number 10000000000, expected at most 999999999"},
      {"a row of commas",
       [](F f) { put(f + "/timestamps.csv", "frame,host_ns\n" + std::string(1 << 20, ',') + "x\n"); },
       ErrorCode::corrupt, "has more than 64 cells"},
  };
  return table;
}

TEST(Folder, EveryBadOneIsRefusedWithOneLineNamingTheFile) {
  for (const BadFolder& bad : bad_folders()) {
    SCOPED_TRACE(bad.name);
    const TestFolder folder;
    make_folder(folder.path("rec"));
    bad.spoil(folder.path("rec"));
    const auto source = open_source(folder.path("rec"));
    ASSERT_FALSE(source);
    const Error& error = source.error();
    EXPECT_EQ(error.code, bad.code) << error.message;
    EXPECT_TRUE(contains(error.message, bad.names)) << error.message;
    EXPECT_TRUE(contains(error.message, folder.path("rec"))) << error.message;
    EXPECT_FALSE(contains(error.message, "\n")) << error.message;
  }
}

TEST(Folder, ADamagedFrameIsSkippedWithItsNameAndTheNextOneComes) {
  for (const DepthFormat format : {DepthFormat::png, DepthFormat::pgm}) {
    const TestFolder folder;
    make_folder(folder.path("rec"), format);
    const std::string name = format == DepthFormat::png ? "000001.png" : "000001.pgm";
    std::filesystem::resize_file(folder.path("rec/" + name), 1500);
    auto source = FolderSource::open(folder.path("rec"));
    ASSERT_TRUE(source) << source.error().message;
    Picture out(kWidth, kHeight);
    ASSERT_TRUE((*source)->next(out.image(), 0));
    const auto bad = (*source)->next(out.image(), 0);
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, ErrorCode::corrupt);
    EXPECT_TRUE(contains(bad.error().message, name)) << bad.error().message;
    EXPECT_EQ((*source)->next(out.image(), 0)->sequence, 2U);
    EXPECT_EQ((*source)->stats().damaged, 1U);
    EXPECT_EQ((*source)->stats().gaps, 1U);
  }
}

// One rule, whatever the damage.
TEST(Folder, EveryKindOfDamageIsOneFrameLessAndCounted) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 6);
  put(folder.path("rec/000000.png"), "");
  put(folder.path("rec/000001.png"), "P5");
  put(folder.path("rec/000002.png"), "no picture at all");
  std::filesystem::resize_file(folder.path("rec/000003.png"), 20);
  auto source = FolderSource::open(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWidth, kHeight);
  for (int i = 0; i < 4; ++i) EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::corrupt) << i;
  EXPECT_EQ((*source)->next(out.image(), 0)->sequence, 4U);
  EXPECT_EQ((*source)->next(out.image(), 0)->sequence, 5U);
  EXPECT_EQ((*source)->stats().damaged, 4U);
}

// A FIFO waits for its writer for ever; the names of a folder do not say what is one.
TEST(Folder, AFifoIsRefusedAtOnce) {
  for (const char* name : {"000001.png", "camera.yaml", "timestamps.csv"}) {
    const TestFolder folder;
    make_folder(folder.path("rec"));
    std::filesystem::remove(folder.path(std::string("rec/") + name));
    ASSERT_EQ(::mkfifo(folder.path(std::string("rec/") + name).c_str(), 0600), 0);
    const auto source = FolderSource::open(folder.path("rec"));
    ASSERT_FALSE(source) << name;
    EXPECT_TRUE(contains(source.error().message, "not a regular file")) << source.error().message;
  }
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
  const Picture stored = random_picture(kWidth, kHeight, 0);
  for (const double unit_mm : {0.1, 0.125, 10.0}) {
    FolderOptions options;
    options.unit_mm = unit_mm;
    auto source = FolderSource::open(folder.path("rec"), options);
    ASSERT_TRUE(source);
    Picture out(kWidth, kHeight);
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
  absurd.unit_mm = 0;
  EXPECT_FALSE(FolderSource::open(folder.path("rec"), absurd));
}

TEST(Folder, TimesAsASpreadsheetWritesThemAreRead) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 2);
  put(folder.path("rec/timestamps.csv"), "\xEF\xBB\xBF\"frame\";\"host_ns\";\r\n0;1000;\r\n1;2000;\r\n");
  auto source = FolderSource::open(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWidth, kHeight);
  EXPECT_EQ((*source)->next(out.image(), 0)->host_ns, 1000);
  EXPECT_EQ((*source)->next(out.image(), 0)->host_ns, 2000);
}

// A few kilobytes of text may expand to gigabytes; libpng did so, chunk after chunk.
TEST(Folder, TextsInAPngAreNotExpanded) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 1);
  const auto whole = read_file(folder.path("rec/000000.png"));
  ASSERT_TRUE(whole);
  std::string zeros(7 << 20, '\0'), packed(1 << 16, '\0');
  uLongf size = packed.size();
  ASSERT_EQ(compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(zeros.data()),
                      zeros.size(), 9),
            Z_OK);
  packed.resize(size);
  const std::string body = "zTXtname" + std::string(2, '\0') + packed;
  const auto big_endian = [](std::uint32_t v) {
    return std::string{static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
                       static_cast<char>(v)};
  };
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  const std::string chunk =
      big_endian(static_cast<std::uint32_t>(body.size() - 4)) + body + big_endian(static_cast<std::uint32_t>(sum));
  std::string bomb(reinterpret_cast<const char*>(whole->data()), 33);  // signature and IHDR
  for (int i = 0; i < 900; ++i) bomb += chunk;
  bomb.append(reinterpret_cast<const char*>(whole->data()) + 33, whole->size() - 33);
  Picture out(kWidth, kHeight);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(decode_depth(std::as_bytes(std::span(bomb)), "bomb", out.image()));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2)) << "6 GB of zeros are in it";
  EXPECT_EQ(out.pixels, random_picture(kWidth, kHeight, 0).pixels);
}

TEST(Folder, APngWithAFlippedByteNeverPassesForWhole) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 1);
  const std::string path = folder.path("rec/000000.png");
  const auto good = read_file(path);
  ASSERT_TRUE(good);
  Rng rng(11);
  const Picture truth = random_picture(kWidth, kHeight, 0);
  for (int i = 0; i < 200; ++i) {
    auto bytes = *good;
    bytes[static_cast<std::size_t>(rng.index(static_cast<int>(bytes.size())))] ^= std::byte{0x20};
    Picture out(kWidth, kHeight);
    if (decode_depth(bytes, "flipped", out.image())) {
      EXPECT_EQ(out.pixels, truth.pixels) << i;
    }
  }
}

TEST(FolderWriter, RefusesAFolderThatHoldsFramesAndOneItCannotMake) {
  const TestFolder folder;
  make_folder(folder.path("rec"));
  const auto again = FolderWriter::create(folder.path("rec"), camera_of(kWidth, kHeight), {});
  ASSERT_FALSE(again);
  EXPECT_TRUE(contains(again.error().message, "already holds frames")) << again.error().message;
  put(folder.path("file"), "a file, not a folder");
  const auto blocked = FolderWriter::create(folder.path("file/rec"), camera_of(kWidth, kHeight), {});
  ASSERT_FALSE(blocked);
  EXPECT_TRUE(contains(blocked.error().message, folder.path("file/rec"))) << blocked.error().message;
  EXPECT_FALSE(FolderWriter::create("/proc/im2fit", camera_of(kWidth, kHeight), {}));
}

// The file-size limit stands in for a full disk: write() fails midway through a file all the same.
TEST(FolderWriter, AFullDiskGivesOneLineAndLeavesNoHalfFrame) {
  const TestFolder folder;
  FolderWriter::Options options;
  options.format = DepthFormat::pgm;
  auto writer = FolderWriter::create(folder.path("rec"), camera_of(kWidth, kHeight), options);
  ASSERT_TRUE(writer);
  const Picture frame = random_picture(kWidth, kHeight, 1);
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

TEST(OpenSource, WordsThatAreNoSourceAreRefusedClearly) {
  const TestFolder folder;
  put(folder.path("notes.txt"), "hello");
  const struct {
    std::string uri;
    ErrorCode code;
    const char* names;
  } cases[] = {{"synthetic:7", ErrorCode::unsupported, "no synthetic camera"},
               {folder.path("absent.oni"), ErrorCode::not_found, "does not exist"},
               {"", ErrorCode::not_found, "does not exist"},
               {folder.path("notes.txt"), ErrorCode::unsupported, "neither a folder nor a .oni"}};
  for (const auto& bad : cases) {
    const auto source = open_source(bad.uri);
    ASSERT_FALSE(source) << bad.uri;
    EXPECT_EQ(source.error().code, bad.code) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, bad.names)) << source.error().message;
  }
}

TEST(OpenSource, TheSyntheticFactoryGetsTheSeedAndTheOptions) {
  std::string seed;
  int rotate_deg = -1;
  OpenOptions options;
  options.rotate_deg = 270;
  options.synthetic = [&](const std::string& word, const OpenOptions& given) -> Result<std::unique_ptr<Source>> {
    seed = word;
    rotate_deg = given.rotate_deg.value_or(-1);
    return Error{ErrorCode::not_found, "called"};
  };
  EXPECT_FALSE(open_source("synthetic:42", options));
  EXPECT_EQ(seed, "42");
  EXPECT_EQ(rotate_deg, 270);
  EXPECT_FALSE(open_source("synthetic", options));
  EXPECT_EQ(seed, "");
}

// As they come from ROS 2, Open3D and makers' programs.
TEST(CameraYaml, CalibrationsOfOthersAreRead) {
  const char* const kTexts[] = {
      "header:\n  stamp: {sec: 1, nanosec: 2}\n  frame_id: camera\nheight: 480\nwidth: 640\n"
      "distortion_model: plumb_bob\nd: [0.0, 0.0, 0.0, 0.0, 0.0]\nk: [570.0, 0.0, 320.0, 0.0, 571.0, 240.0, 0.0, "
      "0.0, 1.0]\n"
      "r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\nbinning_x: 0\n---\n",
      R"({"width": 640, "height": 480, "intrinsic_matrix": [570.0, 0, 0, 0, 571.0, 0, 320.0, 240.0, 1]})",
      R"({"width": 640, "height": 480, "fx": 570.0, "fy": 571.0, "ppx": 320.0, "ppy": 240.0, "model": "Brown Conrady", "coeffs": [0,0,0,0,0]})",
      R"({"depth": {"intrinsic": {"width": 640, "height": 480, "fx": 570.0, "fy": 571.0, "cx": 320.0, "cy": 240.0}}})"};
  for (const char* text : kTexts) {
    const auto file = parse_camera_yaml(text, "camera.yaml");
    ASSERT_TRUE(file) << file.error().message << "\n" << text;
    const Intrinsics& k = file->intrinsics;
    EXPECT_EQ(k.width, 640);
    EXPECT_EQ(k.height, 480);
    EXPECT_EQ(k.fx, 570.0F);
    EXPECT_EQ(k.fy, 571.0F);
    EXPECT_EQ(k.cx, 320.0F);
    EXPECT_EQ(k.cy, 240.0F);
  }
  EXPECT_FALSE(parse_camera_yaml(R"({"width": 640, "height": 480, "fx": 570.0})", "camera.yaml"));
  EXPECT_FALSE(parse_camera_yaml(R"({"depth": {"depth": {"depth": 1}}})", "camera.yaml"));
}

TEST(CameraYaml, AnErrorThatQuotesTheFileIsStillOneLine) {
  const auto file = parse_camera_yaml(
      "image_width: 4\nimage_height: 3\ncamera_matrix: {data: [3, 0, 1, 0, 3, 1, 0, 0, 1]}\n"
      "distortion_coefficients: [1, 0, 0, 0]\ndistortion_model: \"fish\\neye\"\n",
      "camera.yaml");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::unsupported);
  EXPECT_FALSE(contains(file.error().message, "\n"));
  EXPECT_TRUE(contains(file.error().message, "fish eye"));
}

}  // namespace
}  // namespace im2fit::hal
