// SPDX-License-Identifier: Apache-2.0
// One reader for each format of scan_file.h. They share limits, words and numbers of text, and little pieces of
// binary.
#pragma once

#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/status.h"
#include "core/vec3.h"
#include "hal/scan/scan_file.h"

namespace im2fit::hal {

inline constexpr std::size_t kScanBytesMax = std::size_t{512} << 20;
// A scanner's finest mesh of a person has some two million.
inline constexpr std::size_t kScanPointsMax = 10'000'000, kScanTrianglesMax = 10'000'000;
// Of a coordinate, in the file's unit. Farther out single precision has no millimetres left.
inline constexpr float kScanReach = 1e7F;

// Before they are checked: a point may not be finite, a corner may not exist.
struct RawScan {
  std::vector<Vec3f> points;
  std::vector<ScanTriangle> triangles;
};

using ScanBytes = std::span<const std::byte>;
// `what`: the file's name, for errors.
Result<RawScan> read_ply(ScanBytes bytes, const std::string& what);
Result<RawScan> read_obj(ScanBytes bytes, const std::string& what);
Result<RawScan> read_glb(ScanBytes bytes, const std::string& what);
Result<RawScan> read_pcd(ScanBytes bytes, const std::string& what);

// Without points that are not finite or out of reach, and the faces of these. Error: a corner that is no point; no
// points.
Result<Scan> checked_scan(RawScan raw, const std::string& what);

inline Error bad_scan(const std::string& what, const std::string& why) {
  return {ErrorCode::corrupt, what + ": " + why + "; export it again"};
}

inline std::string_view text_of(ScanBytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The text up to the next end of line, taken off `text`. An ending \r is left out.
inline std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

// The next word between blanks, taken off `text`; "" at its end.
inline std::string_view take_word(std::string_view& text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; };
  std::size_t from = 0;
  while (from < text.size() && blank(text[from])) ++from;
  std::size_t to = from;
  while (to < text.size() && !blank(text[to])) ++to;
  const std::string_view word = text.substr(from, to - from);
  text.remove_prefix(to);
  return word;
}

// The whole word as a whole number.
template <class T>
std::optional<T> number_of(std::string_view word) {
  static_assert(std::is_integral_v<T>);
  if (word.starts_with("+-")) return std::nullopt;
  if (word.starts_with('+')) word.remove_prefix(1);
  T value{};
  const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || read.ptr != word.data() + word.size() || read.ec != std::errc{}) return std::nullopt;
  return value;
}

// The whole word as a decimal number, to 15 digits; "nan" and "inf" are not finite. from_chars for floats is not in
// every standard library we build with.
std::optional<double> decimal_of(std::string_view word);

// A number of a file's bytes; the caller has checked that they are there.
template <class T>
T piece_of(const std::byte* at, bool big_endian = false) {
  std::byte bytes[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = at[big_endian ? sizeof(T) - 1 - i : i];
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}
static_assert(std::endian::native == std::endian::little);

}  // namespace im2fit::hal
