// SPDX-License-Identifier: Apache-2.0
// Values as literals of C++, for tables that are compiled in.
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <string_view>

namespace im2fit {

// UTF-8 stands as it is.
inline std::string quoted_literal(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

// The shortest text that reads back as the same float.
inline std::string float_literal(float value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  std::string out(text.data(), error == std::errc() ? end : text.data());
  if (out.find_first_of(".e") == std::string::npos) out += ".0";
  return out + "F";
}

}  // namespace im2fit
