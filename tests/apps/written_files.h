// SPDX-License-Identifier: Apache-2.0
// What a program left in a folder, judged by the formats' own rules.
#pragma once

#include <png.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "depth_folder.h"

namespace im2fit::test {

// libpng reads over a missing end; PNG (third edition), section 11.2.5, asks for an empty IEND chunk there.
inline bool is_whole_png(const std::string& path) {
  const std::string bytes = read_text(path);
  const std::string end("\0\0\0\0IEND\xAE\x42\x60\x82", 12);
  if (bytes.size() < end.size() || bytes.compare(bytes.size() - end.size(), end.size(), end) != 0) return false;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return false;
  std::vector<png_byte> pixels(PNG_IMAGE_SIZE(image));
  return png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) != 0;
}

// Binary glTF 2.0, section 4.4.2: magic, version, length of the whole file.
inline bool is_whole_glb(const std::string& bytes) {
  std::uint32_t length = 0;
  if (bytes.size() < 12 || bytes.rfind("glTF", 0) != 0) return false;
  std::memcpy(&length, bytes.data() + 8, sizeof length);
  return length == bytes.size();
}

inline bool is_whole(const std::filesystem::path& path) {
  const std::string bytes = read_text(path);
  const std::string kind = path.extension();
  if (kind == ".json") return nlohmann::json::accept(bytes);
  if (kind == ".png") return is_whole_png(path);
  if (kind == ".glb") return is_whole_glb(bytes);
  const bool text = kind == ".obj" || kind == ".mtl" || kind == ".bvh" || kind == ".yaml" || kind == ".csv";
  return text && !bytes.empty() && bytes.back() == '\n';
}

inline std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code absent;
  for (const auto& entry : std::filesystem::directory_iterator(folder, absent))
    names.push_back(entry.path().filename().string());
  return names;
}

// Names of files that are cut off, temporary or of no kind the programs write.
inline std::vector<std::string> partial_files_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const std::string& name : files_in(folder))
    if (!is_whole(std::filesystem::path(folder) / name)) names.push_back(name);
  return names;
}

}  // namespace im2fit::test
