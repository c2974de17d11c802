// SPDX-License-Identifier: Apache-2.0
// Depth folders written with nothing of the program's: PGM by hand, PNG by libpng, camera.yaml as text.
#pragma once

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace im2fit::test {

// A folder of the test's own, removed with it.
class TestFolder {
 public:
  TestFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-apps-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;
  ~TestFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string path(const std::string& name = "") const { return name.empty() ? path_ : path_ + "/" + name; }

 private:
  std::string path_;
};

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}
inline std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Picture {
  int width = 320;
  int height = 240;
  std::vector<std::uint16_t> mm;
  Picture(int w, int h, int value_mm)
      : width(w),
        height(h),
        mm(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), static_cast<std::uint16_t>(value_mm)) {}
  std::uint16_t& at(int u, int v) {
    return mm[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
  }
  std::uint16_t at(int u, int v) const { return const_cast<Picture*>(this)->at(u, v); }
};

inline std::string pgm(const Picture& picture, int maxval = 65535) {
  std::string text = "P5\n" + std::to_string(picture.width) + " " + std::to_string(picture.height) + "\n" +
                     std::to_string(maxval) + "\n";
  for (const std::uint16_t value : picture.mm) {
    if (maxval > 255) text += static_cast<char>(value >> 8);
    text += static_cast<char>(value & 0xFF);
  }
  return text;
}

// Grey, `bits` 8 or 16.
inline std::string png(const Picture& picture, int bits = 16) {
  std::string text;
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(writer);
  png_set_write_fn(
      writer, &text,
      [](png_structp p, png_bytep data, png_size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<const char*>(data), size);
      },
      nullptr);
  png_set_IHDR(writer, info, static_cast<png_uint_32>(picture.width), static_cast<png_uint_32>(picture.height), bits,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer, info);
  for (int v = 0; v < picture.height; ++v) {
    std::vector<png_byte> row;
    for (int u = 0; u < picture.width; ++u) {
      if (bits == 16) row.push_back(static_cast<png_byte>(picture.at(u, v) >> 8));
      row.push_back(static_cast<png_byte>(picture.at(u, v) & 0xFF));
    }
    png_write_row(writer, row.data());
  }
  png_write_end(writer, info);
  png_destroy_write_struct(&writer, &info);
  return text;
}

struct CameraText {
  int width = 320;
  int height = 240;
  std::string focal_x = "287.9";
  std::string focal_y = "287.9";
  double centre_x = 159.5;
  double centre_y = 119.5;
  int rotate_deg = 0;
};

inline std::string camera_yaml(const CameraText& camera) {
  return "image_width: " + std::to_string(camera.width) + "\nimage_height: " + std::to_string(camera.height) +
         "\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [" + camera.focal_x + ", 0, " +
         std::to_string(camera.centre_x) + ", 0, " + camera.focal_y + ", " + std::to_string(camera.centre_y) +
         ", 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n"
         "  data: [0, 0, 0, 0, 0]\nim2fit_rotate_deg: " +
         std::to_string(camera.rotate_deg) + "\n";
}

inline std::string frame_name(int number, const std::string& ending) {
  std::string digits = std::to_string(number);
  return std::string(6 - digits.size(), '0') + digits + "." + ending;
}

// `folder` with camera.yaml and these pictures as PGM.
inline void write_depth_folder(const std::string& folder, const std::vector<Picture>& pictures,
                               const CameraText& camera = {}) {
  std::filesystem::create_directories(folder);
  write_text(folder + "/camera.yaml", camera_yaml(camera));
  for (std::size_t i = 0; i < pictures.size(); ++i)
    write_text(folder + "/" + frame_name(static_cast<int>(i), "pgm"), pgm(pictures[i]));
}

}  // namespace im2fit::test
