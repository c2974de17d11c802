// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <chrono>
#include <functional>
#include <span>

#include "hal/folder/camera_yaml.h"
#include "hal/open/open.h"
#include "made_folder.h"

namespace im2fit::hal {
namespace {

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
  const std::string text = yaml_of(camera_of(kMadeWidth, kMadeHeight), "x", 0);
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
      {"8-bit png", [](F f) { eight_bit_png(f + "/000000.png"); }, ErrorCode::unsupported, "000000.png is a 8-bit"},
      {"pictures that are none",
       [](F f) {
         for (int i = 0; i < 4; ++i) put(f + "/00000" + std::to_string(i) + ".png", "P2\n48 40\n65535\n1 2 3");
       },
       ErrorCode::corrupt, "000000.png is neither"},
      {"number twice", [](F f) { other_size(f + "/000001.pgm", 48, 40); }, ErrorCode::invalid_argument,
       "same frame number"},
      {"no camera.yaml", [](F f) { std::filesystem::remove(f + "/camera.yaml"); }, ErrorCode::not_found,
       "camera.yaml is missing"},
      {"camera.yaml of another size", [](F f) { put(f + "/camera.yaml", yaml_of(camera_of(64, 40), "other", 0)); },
       ErrorCode::invalid_argument, "camera.yaml is for 64x40"},
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
       ErrorCode::corrupt, "timestamps.csv line 2: down_y is not a number"},
      {"down too long", [](F f) { put(f + "/timestamps.csv", "frame,host_ns,down_x,down_y,down_z\n0,1,0,2,0\n"); },
       ErrorCode::corrupt, "timestamps.csv line 2: down_x, down_y, down_z are not a vector of length 1"},
      {"half of down", [](F f) { put(f + "/timestamps.csv", "frame,host_ns,down_x,down_y,down_z\n0,1,,1,\n"); },
       ErrorCode::corrupt, "timestamps.csv line 2: down_x, down_y, down_z are not a vector of length 1"},
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

// Opening lists the folder; what is wrong with a later picture is reported when its turn comes.
TEST(Folder, APictureOfAnotherKindOrSizeEndsTheRecordingWithOneLine) {
  using F = const std::string&;
  const BadFolder table[] = {
      {"8-bit png", [](F f) { eight_bit_png(f + "/000002.png"); }, ErrorCode::unsupported, "000002.png is a 8-bit"},
      {"8-bit pgm", [](F f) { put(f + "/000009.pgm", "P5\n48 40\n255\n" + std::string(48 * 40, 'x')); },
       ErrorCode::unsupported, "000009.pgm has maxval 255"},
      {"two sizes", [](F f) { other_size(f + "/000004.pgm", 50, 40); }, ErrorCode::invalid_argument,
       "000004.pgm is 50x40, expected 48x40"},
      {"too large", [](F f) { put(f + "/000004.pgm", "P5 4096 40 65535\n"); }, ErrorCode::unsupported, "4096x40"},
  };
  for (const BadFolder& bad : table) {
    SCOPED_TRACE(bad.name);
    const TestFolder folder;
    make_folder(folder.path("rec"));
    std::filesystem::remove(folder.path("rec/timestamps.csv"));
    bad.spoil(folder.path("rec"));
    const auto source = open_source(folder.path("rec"));
    ASSERT_TRUE(source) << source.error().message;
    Picture out(kMadeWidth, kMadeHeight);
    auto frame = (*source)->next(out.image(), 0);
    EXPECT_TRUE(frame);
    while (frame) frame = (*source)->next(out.image(), 0);
    EXPECT_EQ(frame.error().code, bad.code) << frame.error().message;
    EXPECT_TRUE(contains(frame.error().message, bad.names)) << frame.error().message;
    EXPECT_TRUE(contains(frame.error().message, folder.path("rec"))) << frame.error().message;
    EXPECT_EQ((*source)->stats().damaged, 0U);
  }
}

// Nothing of the pictures after the first sound one is read: links to nowhere show it.
TEST(Folder, IsListedNotOpened) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 2);
  std::filesystem::remove(folder.path("rec/timestamps.csv"));
  for (int i = 2; i < 1000; ++i) {
    const std::string number = std::to_string(i);
    std::filesystem::create_symlink("nowhere.png",
                                    folder.path("rec/" + std::string(6 - number.size(), '0') + number + ".png"));
  }
  const auto source = FolderSource::open(folder.path("rec"));
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().frame_count, 1000);
  Picture out(kMadeWidth, kMadeHeight);
  EXPECT_TRUE((*source)->next(out.image(), 0));
  EXPECT_TRUE((*source)->next(out.image(), 0));
  EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::corrupt);
}

TEST(Folder, ADamagedFrameIsSkippedWithItsNameAndTheNextOneComes) {
  for (const DepthFormat format : {DepthFormat::png, DepthFormat::pgm}) {
    const TestFolder folder;
    make_folder(folder.path("rec"), format);
    const std::string name = format == DepthFormat::png ? "000001.png" : "000001.pgm";
    std::filesystem::resize_file(folder.path("rec/" + name), 1500);
    auto source = FolderSource::open(folder.path("rec"));
    ASSERT_TRUE(source) << source.error().message;
    Picture out(kMadeWidth, kMadeHeight);
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
  Picture out(kMadeWidth, kMadeHeight);
  for (int i = 0; i < 4; ++i) EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::corrupt) << i;
  EXPECT_EQ((*source)->next(out.image(), 0)->sequence, 4U);
  EXPECT_EQ((*source)->next(out.image(), 0)->sequence, 5U);
  EXPECT_EQ((*source)->stats().damaged, 4U);
}

// A FIFO waits for its writer for ever; the names in a folder do not show which file is one.
TEST(Folder, AFifoIsRefusedAtOnce) {
  for (const char* name : {"000000.png", "camera.yaml", "timestamps.csv"}) {
    const TestFolder folder;
    make_folder(folder.path("rec"));
    std::filesystem::remove(folder.path(std::string("rec/") + name));
    ASSERT_EQ(::mkfifo(folder.path(std::string("rec/") + name).c_str(), 0600), 0);
    const auto source = FolderSource::open(folder.path("rec"));
    ASSERT_FALSE(source) << name;
    EXPECT_TRUE(contains(source.error().message, "not a regular file")) << source.error().message;
  }
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
  Picture out(kMadeWidth, kMadeHeight);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(decode_depth(std::as_bytes(std::span(bomb)), "bomb", out.image()));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2)) << "6 GB of zeros are in it";
  EXPECT_EQ(out.pixels, random_picture(kMadeWidth, kMadeHeight, 0).pixels);
}

TEST(Folder, APngWithAFlippedByteNeverPassesForWhole) {
  const TestFolder folder;
  make_folder(folder.path("rec"), DepthFormat::png, 1);
  const std::string path = folder.path("rec/000000.png");
  const auto good = read_file(path);
  ASSERT_TRUE(good);
  Rng rng(11);
  const Picture truth = random_picture(kMadeWidth, kMadeHeight, 0);
  for (int i = 0; i < 200; ++i) {
    auto bytes = *good;
    bytes[static_cast<std::size_t>(rng.index(static_cast<int>(bytes.size())))] ^= std::byte{0x20};
    Picture out(kMadeWidth, kMadeHeight);
    if (decode_depth(bytes, "flipped", out.image())) {
      EXPECT_EQ(out.pixels, truth.pixels) << i;
    }
  }
}

}  // namespace
}  // namespace im2fit::hal
