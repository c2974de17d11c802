// SPDX-License-Identifier: Apache-2.0
// Makes external text (names and contents of files) safe to display.
#pragma once

#include <cstddef>
#include <string>

namespace im2fit {

// The same with a space for every control character: a terminal would obey the escape sequences of a hostile file's
// name, and a log would have two lines. UTF-8 stays; its control characters U+0080 to U+009F go too.
inline std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c < 0x20 || c == 0x7F) text[i] = ' ';
    if (c != 0xC2 || i + 1 == text.size()) continue;
    const auto next = static_cast<unsigned char>(text[i + 1]);
    if (next >= 0x80 && next < 0xA0) text[i] = text[i + 1] = ' ';
  }
  return text;
}

// The same, of a length that a message can bear: a hostile file has a megabyte in one field.
inline std::string excerpt(const std::string& text) {
  constexpr std::size_t kBytesMax = 60;
  if (text.size() <= kBytesMax) return printable(text);
  std::size_t end = kBytesMax;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a letter
  return printable(text.substr(0, end)) + "...";
}

// Letters as people count them: the code points of UTF-8.
inline std::size_t character_count(const std::string& text) {
  std::size_t count = 0;
  for (const char c : text) count += (static_cast<unsigned char>(c) & 0xC0) != 0x80 ? 1 : 0;
  return count;
}

}  // namespace im2fit
