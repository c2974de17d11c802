// SPDX-License-Identifier: Apache-2.0
// The one reader of JSON that others wrote, and the one way to write text from outside as JSON. A header alone: each
// program links nlohmann-json itself.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/file.h"
#include "core/status.h"

namespace im2fit {

// Levels of brackets; our own files have six. A value is printed, copied and compared by recursion: 100,000 levels,
// 200 kB of text, end the program for want of stack.
inline constexpr std::size_t kJsonDepthMax = 64;
// Keys of one object; MakeHuman's list of targets has some thousand. Ordered objects look a key up one by one: 95,000
// keys, 900 kB of text, take 20 s. So the squares of the counts may together not be more than this one's.
inline constexpr std::size_t kJsonKeysMax = 10'000;

// The limit that a text exceeds, or "". Reads brackets, commas and quotes alone. The parser refuses text that is not
// JSON, and its stack does not grow with the levels.
inline std::string json_excess(std::string_view text) {
  std::array<std::size_t, kJsonDepthMax> commas{};
  std::size_t depth = 0, cost = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (c == '\\' && quoted) ++i;
    if (quoted) continue;
    if (c == '[' || c == '{') {
      if (depth == kJsonDepthMax) return "nested deeper than " + std::to_string(kJsonDepthMax) + " levels";
      // A list may have any length: its commas are not looked at.
      commas[depth++] = c == '{' ? 0 : SIZE_MAX;
    }
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (c != ',' || depth == 0 || commas[depth - 1] == SIZE_MAX) continue;
    cost += 2 * ++commas[depth - 1] + 1;
    if (commas[depth - 1] >= kJsonKeysMax || cost > kJsonKeysMax * kJsonKeysMax)
      return "has an object of more than " + std::to_string(kJsonKeysMax) + " keys, or many of nearly as many";
  }
  return "";
}

// Error: corrupt, when the text is not JSON in UTF-8 or exceeds a limit; it begins with `what`.
template <class Json = nlohmann::json>
Result<Json> parse_json(std::string_view text, const std::string& what) {
  if (const std::string excess = json_excess(text); !excess.empty())
    return Error{ErrorCode::corrupt, what + ": " + excess};
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) return Error{ErrorCode::corrupt, what + ": not JSON; is it cut off?"};
  return json;
}

// Errors: as read_file; as parse_json.
template <class Json = nlohmann::json>
Result<Json> read_json(const std::string& path, std::size_t size_max = kReadBytesMax) {
  const auto bytes = read_file(path, size_max);
  if (!bytes) return bytes.error();
  return parse_json<Json>({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

// A name of a file, camera or shop may have bytes that are not UTF-8. dump() throws at them; this replaces them.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace im2fit
