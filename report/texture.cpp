// SPDX-License-Identifier: Apache-2.0
#include "report/texture.h"

#include <png.h>

#include <algorithm>
#include <string>

#include "body/look.h"

namespace im2fit {

Result<Texture> Texture::decode(std::span<const std::byte> png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto failed = [&] {
    Error error{ErrorCode::corrupt, std::string("texture: ") + image.message};
    png_image_free(&image);
    return error;
  };
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return failed();
  if (image.width > body::kTextureSideMax || image.height > body::kTextureSideMax) {
    png_image_free(&image);
    return Error{ErrorCode::corrupt,
                 "texture: more than " + std::to_string(body::kTextureSideMax) + " pixels along a side"};
  }
  image.format = PNG_FORMAT_RGB;
  Texture texture;
  texture.width_ = static_cast<int>(image.width);
  texture.height_ = static_cast<int>(image.height);
  texture.rgb_.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, texture.rgb_.data(), 0, nullptr) == 0) return failed();
  return texture;
}

std::array<float, 3> Texture::at(float u, float v) const {
  const float x = std::clamp(u * static_cast<float>(width_) - 0.5F, 0.0F, static_cast<float>(width_ - 1));
  const float y = std::clamp(v * static_cast<float>(height_) - 0.5F, 0.0F, static_cast<float>(height_ - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, width_ - 1), y1 = std::min(y0 + 1, height_ - 1);
  const float right = x - static_cast<float>(x0), below = y - static_cast<float>(y0);
  std::array<float, 3> sum{};
  const auto add = [&](int column, int row, float share) {
    const std::uint8_t* pixel = &rgb_[static_cast<std::size_t>(3 * (row * width_ + column))];
    for (std::size_t i = 0; i < 3; ++i) {
      const float display = static_cast<float>(pixel[i]) / 255;
      sum[i] += share * display * display;  // the inverse of what pictures are displayed with
    }
  };
  add(x0, y0, (1 - right) * (1 - below));
  add(x1, y0, right * (1 - below));
  add(x0, y1, (1 - right) * below);
  add(x1, y1, right * below);
  return sum;
}

}  // namespace im2fit
