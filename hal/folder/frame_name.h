// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include "hal/folder/depth_file.h"

namespace im2fit::hal {

// "000012.png" -> 12; none for any other kind of name.
inline std::optional<std::uint64_t> frame_number(const std::string& name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos || dot == 0 || dot > 15) return std::nullopt;
  const std::string extension = name.substr(dot);
  if (extension != ".png" && extension != ".pgm") return std::nullopt;
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < dot; ++i) {
    if (name[i] < '0' || name[i] > '9') return std::nullopt;
    number = number * 10 + static_cast<std::uint64_t>(name[i] - '0');
  }
  return number;
}

inline std::string frame_name(std::uint64_t number, DepthFormat format) {
  char text[32];
  std::snprintf(text, sizeof text, "%06" PRIu64 ".%s", number, format == DepthFormat::png ? "png" : "pgm");
  return text;
}

}  // namespace im2fit::hal
