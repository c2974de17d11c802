// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/small_picture.h"

#include <png.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/guidance.h"

namespace im2fit::apps {
namespace {

// Of 255. What is behind the person stays dark; a step between them even for a person far away.
constexpr int kBehindMost = 90;
constexpr int kPersonLeast = 140, kPersonMost = 240;
// Steps of grey: fewer make a smaller file (8 instead of 256 take 40 % off), and shapes are what matters here.
constexpr int kStep = 10;
constexpr int kNearMm = 800;

std::uint8_t grey_of(int depth_mm, bool person) {
  if (depth_mm == 0) return 0;
  const int span = kTooFarMm - kNearMm;
  const int near = span - std::clamp(depth_mm - kNearMm, 0, span);  // 0: far
  const int low = person ? kPersonLeast : 0, high = person ? kPersonMost : kBehindMost;
  const int grey = low + near * (high - low) / span;
  return static_cast<std::uint8_t>(grey / kStep * kStep);
}

}  // namespace

Result<std::string> small_picture(DepthView depth, MaskView mask) {
  const int side = std::max(depth.width, depth.height);
  if (depth.width <= 0 || depth.height <= 0) return Error{ErrorCode::invalid_argument, "the picture has no pixels"};
  const int shown = std::min(kSmallPictureSidePx, side);
  const int width = std::max(1, depth.width * shown / side), height = std::max(1, depth.height * shown / side);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int v = 0; v < height; ++v) {
    const int row = (2 * v + 1) * depth.height / (2 * height);
    for (int u = 0; u < width; ++u) {
      const int column = (2 * u + 1) * depth.width / (2 * width);
      pixels.push_back(grey_of(depth.row(row)[column], mask.pixels != nullptr && mask.row(row)[column] != 0));
    }
  }
  return grey_png(pixels, width, height);
}

Result<std::string> grey_png(std::span<const std::uint8_t> pixels, int width, int height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_GRAY;
  // Room for an incompressible picture: one pass instead of two.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    return Error{ErrorCode::io, std::string("cannot make a PNG: ") + image.message};
  bytes.resize(size);
  return bytes;
}

}  // namespace im2fit::apps
