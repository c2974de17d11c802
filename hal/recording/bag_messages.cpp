// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/bag_messages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <string_view>

#include "core/text.h"

namespace im2fit::hal {
namespace {

constexpr std::uint32_t kWordMax = 4096;  // frames and encodings have names

// MessageFields one after another, little-endian; the first that fails ends it.
class MessageFields {
 public:
  MessageFields(const BagMessage& message, const std::string& what)
      : message_(message), what_(what), left_(message.size) {}

  std::uint64_t number(std::size_t size) {
    std::array<std::byte, 8> bytes{};
    take(std::span(bytes).first(size));
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | std::to_integer<std::uint64_t>(bytes[i]);
    return value;
  }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  double f64() { return std::bit_cast<double>(number(8)); }
  std::string text() {
    const std::uint32_t size = u32();
    if (size > kWordMax) fail();
    std::string out(status_ ? size : 0, '\0');
    take(std::as_writable_bytes(std::span(out)));
    return out;
  }
  // std_msgs/Header: its time.
  std::int64_t header() {
    u32();
    const std::int64_t seconds = u32();
    const std::int64_t rest = u32();
    text();
    return seconds * 1'000'000'000 + rest;
  }
  std::uint32_t left() const { return left_; }
  void fail() {
    if (status_)
      status_ = Error{ErrorCode::corrupt, what_ + ": a message is not as its type says; copy or record it again"};
  }
  const Status& status() const { return status_; }

 private:
  void take(std::span<std::byte> out) {
    if (out.size() > left_) fail();
    if (status_) status_ = message_.data->read(out);
    if (status_) left_ -= static_cast<std::uint32_t>(out.size());
  }
  const BagMessage& message_;
  const std::string& what_;
  std::uint32_t left_;
  Status status_ = Ok{};
};

std::size_t pixel_bytes(const std::string& encoding) {
  if (encoding == "32FC1") return 4;
  return encoding == "16UC1" || encoding == "mono16" ? 2 : 0;
}

std::uint16_t millimetres(double mm) {
  mm += 0.5;
  return mm >= 1 && mm < 65536 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};  // none, too, of a NaN
}

}  // namespace

bool is_depth_encoding(const std::string& encoding) {
  return pixel_bytes(encoding) != 0;
}

Result<BagImage> read_bag_image(const BagMessage& message, const std::string& what) {
  MessageFields fields(message, what);
  BagImage image;
  image.stamp_ns = fields.header();
  image.height = fields.u32();
  image.width = fields.u32();
  image.encoding = fields.text();
  image.big_endian = fields.number(1) != 0;
  image.step = fields.u32();
  image.data_size = fields.u32();
  const std::uint64_t side = kImageSideMax;
  const bool sized = image.width <= side && image.height <= side &&
                     image.step >= image.width * pixel_bytes(image.encoding) &&
                     image.data_size == std::uint64_t{image.step} * image.height && image.data_size <= fields.left();
  if (is_depth_encoding(image.encoding) && !sized) fields.fail();
  if (auto ok = fields.status(); !ok) return ok.error();
  return image;
}

Status read_bag_pixels(const BagMessage& message, const BagImage& image, double unit_mm, DepthImage picture,
                       std::vector<std::byte>& row, const std::string& what) {
  const std::size_t size = pixel_bytes(image.encoding);
  if (size == 0)
    return Error{ErrorCode::unsupported,
                 what + " has pictures of " + excerpt(image.encoding) + ", expected mono16, 16UC1 or 32FC1"};
  row.resize(static_cast<std::size_t>(picture.width) * size);
  for (int v = 0; v < picture.height; ++v) {
    if (auto ok = message.data->read(row); !ok) return ok;
    message.data->seek(message.data->at() + image.step - row.size());
    for (int u = 0; u < picture.width; ++u) {
      const std::span<const std::byte> bytes = std::span(row).subspan(static_cast<std::size_t>(u) * size, size);
      std::uint32_t bits = 0;
      for (std::size_t i = 0; i < size; ++i)
        bits = bits << 8 | std::to_integer<std::uint32_t>(bytes[image.big_endian ? i : size - 1 - i]);
      if (size == 4)
        picture.at(u, v) = millimetres(1000.0 * static_cast<double>(std::bit_cast<float>(bits)));
      else
        picture.at(u, v) = unit_mm == 1 ? static_cast<std::uint16_t>(bits) : millimetres(bits * unit_mm);
    }
  }
  return Ok{};
}

Result<BagCameraInfo> read_bag_camera_info(const BagMessage& message, const std::string& what) {
  constexpr std::uint32_t kCoefficientsMax = 14;
  MessageFields fields(message, what);
  fields.header();
  BagCameraInfo info;
  info.height = fields.u32();
  info.width = fields.u32();
  info.model = fields.text();
  const std::uint32_t count = fields.u32();
  if (count > kCoefficientsMax) fields.fail();
  for (std::uint32_t i = 0; i < count && i < kCoefficientsMax; ++i) info.distortion.push_back(fields.f64());
  for (double& value : info.k) value = fields.f64();
  for (int i = 0; i < 9; ++i) fields.f64();  // R
  for (double& value : info.p) value = fields.f64();
  if (auto ok = fields.status(); !ok) return ok.error();
  return info;
}

Result<float> read_bag_float(const BagMessage& message, const std::string& what) {
  MessageFields fields(message, what);
  const float value = std::bit_cast<float>(fields.u32());
  if (auto ok = fields.status(); !ok) return ok.error();
  return value;
}

}  // namespace im2fit::hal
