// SPDX-License-Identifier: Apache-2.0
// Grey pictures as other programs write them: with libpng, not with our own writer.
#pragma once

#include <gtest/gtest.h>
#include <png.h>

#include <cstdio>
#include <string>
#include <vector>

namespace im2fit::hal {

template <class Value>
void write_grey_png(const std::string& path, int width, int height, int bits, const Value& value) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr) << path;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  std::vector<png_byte> row;
  for (int v = 0; v < height; ++v) {
    row.clear();
    for (int u = 0; u < width; ++u) {
      const int number = static_cast<int>(value(u, v));
      if (bits == 16) row.push_back(static_cast<png_byte>(number >> 8));
      row.push_back(static_cast<png_byte>(number & 0xFF));
    }
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  ASSERT_EQ(std::fclose(file), 0);
}

}  // namespace im2fit::hal
