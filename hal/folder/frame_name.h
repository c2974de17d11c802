// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include "hal/folder/depth_file.h"

namespace im2fit::hal {

// "000012.png" -> 12; none for any other kind of name. Also what common recorders write: "depth_000012.PNG",
// "frame-000012.depth.png", "000012_depth.pgm".
inline std::optional<std::uint64_t> frame_number(const std::string& name) {
  std::string word;
  for (const char c : name) word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (!word.ends_with(".png") && !word.ends_with(".pgm")) return std::nullopt;
  word.resize(word.size() - 4);
  for (const char* suffix : {".depth", "_depth", "-depth"})
    if (word.ends_with(suffix)) {
      word.resize(word.size() - 6);
      break;
    }
  for (const char* prefix : {"depth", "frame", "image", "img"}) {
    if (!word.starts_with(prefix)) continue;
    word.erase(0, std::char_traits<char>::length(prefix));
    if (word.starts_with("_") || word.starts_with("-")) word.erase(0, 1);
    break;
  }
  if (word.empty() || word.size() > 15) return std::nullopt;
  std::uint64_t number = 0;
  for (const char c : word) {
    if (c < '0' || c > '9') return std::nullopt;
    number = number * 10 + static_cast<std::uint64_t>(c - '0');
  }
  return number;
}

inline std::string frame_name(std::uint64_t number, DepthFormat format) {
  char text[32];
  std::snprintf(text, sizeof text, "%06" PRIu64 ".%s", number, format == DepthFormat::png ? "png" : "pgm");
  return text;
}

}  // namespace im2fit::hal
