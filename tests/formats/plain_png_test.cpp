// SPDX-License-Identifier: Apache-2.0
#include "formats/plain_png.h"

#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "hal/folder/depth_file.h"
#include "tests/hal/hard_pictures.h"

namespace im2fit::hal {
namespace {

std::string big_endian(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8), static_cast<char>(v)};
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return big_endian(static_cast<std::uint32_t>(data.size())) + body + big_endian(static_cast<std::uint32_t>(sum));
}

// As the standard has it (table 9.1): each byte less the filter's prediction from its neighbours.
std::string filtered_rows(const Picture& picture, int filter) {
  std::string rows;
  const auto byte = [&](int i, int v) {
    if (i < 0 || v < 0) return 0;
    const std::uint16_t pixel = picture.view().at(i / 2, v);
    return i % 2 == 0 ? pixel >> 8 : pixel & 0xFF;
  };
  for (int v = 0; v < picture.view().height; ++v) {
    const int kind = filter < 0 ? v % 5 : filter;
    rows += static_cast<char>(kind);
    for (int i = 0; i < 2 * picture.view().width; ++i) {
      const int a = byte(i - 2, v), b = byte(i, v - 1), c = byte(i - 2, v - 1);
      const int p = a + b - c;
      const int pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
      const int paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
      const int prediction[] = {0, a, b, (a + b) / 2, paeth};
      rows += static_cast<char>(byte(i, v) - prediction[kind]);
    }
  }
  return rows;
}

std::string deflated(const std::string& rows) {
  std::string packed(compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  EXPECT_EQ(compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                      rows.size(), 6),
            Z_OK);
  packed.resize(size);
  return packed;
}

std::string header_of(const Picture& picture, char interlaced = 0) {
  const std::string size = big_endian(static_cast<std::uint32_t>(picture.view().width)) +
                           big_endian(static_cast<std::uint32_t>(picture.view().height));
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", size + std::string{16, 0, 0, 0, interlaced});
}

// `piece`: bytes of the stream in an IDAT.
std::string png_of(const Picture& picture, int filter, std::size_t piece = 1 << 20) {
  const std::string stream = deflated(filtered_rows(picture, filter));
  std::string png = header_of(picture) + chunk("tEXt", "by hand");
  for (std::size_t at = 0; at < stream.size(); at += piece) png += chunk("IDAT", stream.substr(at, piece));
  return png + chunk("tEXt", "after") + chunk("IEND", "");
}

bool plain(const std::string& png, Picture& out) {
  return PlainPngDecoder().decode(std::as_bytes(std::span(png)), out.image());
}

TEST(PlainPng, EveryFilterOfEveryPicture) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {64, 48}})
    for (const Picture& picture : hard_pictures(width, height))
      for (int filter = -1; filter < 5; ++filter) {
        const std::string png = png_of(picture, filter);
        Picture out(width, height), swapped(width, height);
        ASSERT_TRUE(decode_depth(std::as_bytes(std::span(png)), "by hand", out.image())) << "filter " << filter;
        ASSERT_EQ(out.pixels, picture.pixels) << "filter " << filter;
        ASSERT_TRUE(plain(png, swapped)) << "not left to libpng";
      }
}

// What a PNG's IDATs inflate to.
std::string rows_of(std::span<const std::byte> bytes, std::size_t size) {
  const std::string png(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string stream;
  for (std::size_t at = 8; at + 12 <= png.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<unsigned char>(png[at + i]);
    if (png.substr(at + 4, 4) == "IDAT") stream += png.substr(at + 8, length);
    at += 12 + length;
  }
  std::string rows(size, '\0');
  uLongf made = rows.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(rows.data()), &made, reinterpret_cast<const Bytef*>(stream.data()),
                       stream.size()),
            Z_OK);
  EXPECT_EQ(made, size);
  return rows;
}

// Structured light's depths repeat from row to row and are written as they are; of others the differences are.
TEST(DepthFile, FewDepthsAreWrittenAsTheyAre) {
  constexpr std::size_t kWidth = 160, kHeight = 120;
  for (const auto& [depth_count, filter] : {std::pair{500U, 0}, {2000U, 2}}) {
    Picture picture(kWidth, kHeight);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
      picture.pixels[i] = static_cast<std::uint16_t>(800 + i * 7919 % depth_count);
    const auto png = encode_depth(picture.view(), DepthFormat::png);
    ASSERT_TRUE(png);
    EXPECT_EQ(rows_of(*png, (1 + 2 * kWidth) * kHeight), filtered_rows(picture, filter)) << depth_count << " depths";
    Picture out(kWidth, kHeight);
    ASSERT_TRUE(decode_depth(*png, "as written", out.image()));
    EXPECT_EQ(out.pixels, picture.pixels);
  }
}

// libpng, which is independent, reads the written file.
TEST(RgbPng, PixelsComeBack) {
  constexpr int kWidth = 61, kHeight = 7;
  std::vector<std::uint8_t> pixels(3 * kWidth * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * i / 7);
  const auto bytes = encode_rgb_png(kWidth, kHeight, pixels);
  ASSERT_TRUE(bytes);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, bytes->data(), bytes->size()), 0) << image.message;
  EXPECT_EQ(image.width, static_cast<png_uint_32>(kWidth));
  EXPECT_EQ(image.height, static_cast<png_uint_32>(kHeight));
  EXPECT_EQ(image.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr), 0) << image.message;
  EXPECT_EQ(read, pixels);
}

TEST(PlainPng, StreamsCutIntoChunksAnywhere) {
  const Picture picture = noisy_picture(64, 48, 3);
  for (const std::size_t piece : {1, 2, 13, 1000}) {
    Picture out(64, 48);
    ASSERT_TRUE(plain(png_of(picture, 4, piece), out)) << piece;
    const std::string png = png_of(picture, 4, piece);
    ASSERT_TRUE(decode_depth(std::as_bytes(std::span(png)), "pieces", out.image()));
    EXPECT_EQ(out.pixels, picture.pixels) << piece;
  }
}

// What is not plain, or not whole, is libpng's to judge.
TEST(PlainPng, LeavesWhatIsNotWhole) {
  const Picture picture = noisy_picture(64, 48, 4);
  const std::string good = png_of(picture, 2);
  const std::string stream = deflated(filtered_rows(picture, 2));
  const std::string end = chunk("IEND", "");
  std::string late = good;  // a CRC that is wrong
  late[late.size() / 2] ^= 1;
  const std::pair<const char*, std::string> cases[] = {
      {"a wrong CRC", late},
      {"cut off", good.substr(0, good.size() - 13)},
      {"a stream cut off", header_of(picture) + chunk("IDAT", stream.substr(0, stream.size() - 9)) + end},
      {"more than the stream", header_of(picture) + chunk("IDAT", stream + "more") + end},
      {"a row too few",
       header_of(picture) + chunk("IDAT", deflated(filtered_rows(noisy_picture(64, 47, 4), 2))) + end},
      {"a row too many",
       header_of(picture) + chunk("IDAT", deflated(filtered_rows(noisy_picture(64, 49, 4), 2))) + end},
      {"no such filter", header_of(picture) + chunk("IDAT", deflated(std::string(48 * 129, 5))) + end},
      {"no deflate stream", header_of(picture) + chunk("IDAT", "\x77" + stream.substr(1)) + end},
      {"a dictionary", header_of(picture) + chunk("IDAT", "\x78\xBB" + stream.substr(2)) + end},
      {"a checksum alone", header_of(picture) + chunk("IDAT", stream.substr(0, 5)) + end},
      {"no pixels", header_of(picture) + end},
      {"an unknown critical chunk", header_of(picture) + chunk("ABCD", "?") + chunk("IDAT", stream) + end},
      {"interlaced", header_of(picture, 1) + chunk("IDAT", stream) + end},
      {"another size", header_of(noisy_picture(64, 47, 4)) + chunk("IDAT", stream) + end},
  };
  Picture out(64, 48);
  ASSERT_TRUE(plain(good, out));
  for (const auto& [what, png] : cases) EXPECT_FALSE(plain(png, out)) << what;
  for (std::size_t size = 0; size < good.size() - 12; size += 7)
    EXPECT_FALSE(plain(good.substr(0, size), out)) << size;
}

}  // namespace
}  // namespace im2fit::hal
