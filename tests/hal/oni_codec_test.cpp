// SPDX-License-Identifier: Apache-2.0
// The encoder against a decoder written here, from the format alone.
#include "hal/openni2/oni_codec.h"

#include <gtest/gtest.h>

#include <optional>
#include <span>

#include "hard_pictures.h"

namespace im2fit::hal {
namespace {

// What a reader of the format takes a picture for; none when it breaks off or names a value that is not there.
class Decoder {
 public:
  explicit Decoder(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::optional<std::vector<std::uint16_t>> pixels() {
    table_.resize(static_cast<std::size_t>(take16()));
    for (auto& value : table_) value = static_cast<std::uint16_t>(take16());
    place_ = take16();
    out_pixel();
    while (good_ && at_ < bytes_.size()) step();
    if (!good_) return std::nullopt;
    return out_;
  }

 private:
  void step() {
    const int byte = take();
    if (byte == 0xFF) return escaped();
    if (byte >= 0xE0) {
      for (int i = 0; i < 2 * (byte - 0xE0); ++i) out_pixel();
      return;
    }
    nibble(byte >> 4);
    const int low = byte & 0xF;
    if (low == 0xF)
      escaped();
    else if (low != 0xD)
      nibble(low);
  }
  void nibble(int code) {
    if (code > 12) good_ = false;
    place_ += 6 - code;
    out_pixel();
  }
  void escaped() {
    const int byte = take();
    place_ = byte >= 128 ? place_ + 192 - byte : byte * 256 + take();
    out_pixel();
  }
  void out_pixel() {
    if (place_ < 0 || place_ >= static_cast<int>(table_.size()))
      good_ = false;
    else
      out_.push_back(table_[static_cast<std::size_t>(place_)]);
  }
  int take() {
    if (at_ < bytes_.size()) return std::to_integer<int>(bytes_[at_++]);
    good_ = false;
    return 0;
  }
  int take16() {
    const int low = take();
    return low + 256 * take();
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
  std::vector<std::uint16_t> table_;
  int place_ = 0;
  std::vector<std::uint16_t> out_;
};

std::vector<std::byte> encoded(DepthView picture) {
  OniEncoder encoder;
  std::vector<std::byte> bytes;
  EXPECT_TRUE(encoder.encode(picture, bytes));
  const auto pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  EXPECT_LE(bytes.size(), OniEncoder::encoded_bytes_max(pixels));
  return bytes;
}

TEST(OniCodec, EveryPictureComesBack) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {3, 1}, {31, 1}, {65, 3}, {320, 240}, {640, 480}}) {
    int number = 0;
    for (const Picture& picture : hard_pictures(width, height)) {
      const auto back = Decoder(encoded(picture.view())).pixels();
      ASSERT_TRUE(back) << number;
      ASSERT_EQ(*back, picture.pixels) << width << "x" << height << ", picture " << number;
      ++number;
    }
  }
}

TEST(OniCodec, ShortPicturesOfAllKindsComeBack) {
  Rng rng(11);
  for (int i = 0; i < 20'000; ++i) {
    Picture picture(1 + rng.index(100), 1);
    const int spread = 1 + rng.index(i % 2 == 0 ? 3 : 200);
    for (auto& pixel : picture.pixels) pixel = static_cast<std::uint16_t>(rng.index(3) == 0 ? rng.index(spread) : 0);
    const auto back = Decoder(encoded(picture.view())).pixels();
    ASSERT_TRUE(back) << i;
    ASSERT_EQ(*back, picture.pixels) << i;
  }
}

// As the format is documented, a run that is open is closed before a half byte that is.
TEST(OniCodec, AnOpenRunIsWrittenBeforeTheLastHalfByte) {
  const auto bytes = [](std::initializer_list<int> values) {
    std::vector<std::byte> list;
    for (const int value : values) list.push_back(static_cast<std::byte>(value));
    return list;
  };
  EXPECT_EQ(encoded(constant_picture(4, 1, 5).view()), bytes({1, 0, 5, 0, 0, 0, 0xE1, 0x6D}));
  EXPECT_EQ(encoded(constant_picture(5, 1, 5).view()), bytes({1, 0, 5, 0, 0, 0, 0xE2}));
  EXPECT_EQ(encoded(constant_picture(34, 1, 0x1234).view()), bytes({1, 0, 0x34, 0x12, 0, 0, 0xEF, 0xE1, 0x6D}));
}

TEST(OniCodec, RowsMayBePadded) {
  const Picture whole = random_picture(100, 20, 3, 500);
  const DepthView part(whole.pixels.data() + 7, 60, 20, 100);
  std::vector<std::uint16_t> expected;
  for (int v = 0; v < part.height; ++v) expected.insert(expected.end(), part.row(v), part.row(v) + part.width);
  EXPECT_EQ(*Decoder(encoded(part)).pixels(), expected);
}

TEST(OniCodec, MoreDifferentDepthsThanItHoldsAreRefused) {
  Picture picture(256, 129);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    picture.pixels[i] = static_cast<std::uint16_t>(std::min<std::size_t>(i, OniEncoder::kValuesMax));
  OniEncoder encoder;
  std::vector<std::byte> bytes(3, std::byte{7});
  EXPECT_FALSE(encoder.encode(picture.view(), bytes));
  EXPECT_EQ(bytes, std::vector<std::byte>(3, std::byte{7}));
  for (auto& pixel : picture.pixels) pixel = std::max(pixel, std::uint16_t{1});
  EXPECT_TRUE(encoder.encode(picture.view(), bytes)) << "one value fewer fits";
  EXPECT_EQ(*Decoder(std::span(bytes).subspan(3)).pixels(), picture.pixels);
  EXPECT_FALSE(encoder.encode(DepthView(picture.pixels.data(), 0, 1), bytes));
}

}  // namespace
}  // namespace im2fit::hal
