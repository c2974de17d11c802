// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: lines "v x y z" and "f a b c", whose corners count from 1, or from the end where they are negative.
// A corner's texture and normal, and every other line, are passed by.
#include "hal/scan/scan_readers.h"

namespace im2fit::hal {
namespace {

// Of "12", "12/3" or "12//4"; none: no point that was read before.
std::optional<std::uint32_t> corner_of(std::string_view word, std::size_t point_count) {
  const auto number = number_of<std::int64_t>(word.substr(0, word.find('/')));
  if (!number || *number == 0) return std::nullopt;
  const std::int64_t place = *number > 0 ? *number - 1 : static_cast<std::int64_t>(point_count) + *number;
  // Faces may stand before their points: the end is checked when all are read.
  if (place < 0 || place >= static_cast<std::int64_t>(kScanPointsMax)) return std::nullopt;
  return static_cast<std::uint32_t>(place);
}

}  // namespace

Result<RawScan> read_obj(ScanBytes bytes, const std::string& what) {
  RawScan scan;
  std::string_view text = text_of(bytes);
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = take_line(text);
    const std::string_view kind = take_word(line);
    if (kind == "v") {
      const auto x = decimal_of(take_word(line)), y = decimal_of(take_word(line)), z = decimal_of(take_word(line));
      if (!x || !y || !z) return bad_scan(what, "line " + std::to_string(number) + " is no \"v x y z\"");
      if (scan.points.size() == kScanPointsMax)
        return bad_scan(what, "it has more than " + std::to_string(kScanPointsMax) + " points");
      scan.points.push_back({static_cast<float>(*x), static_cast<float>(*y), static_cast<float>(*z)});
    } else if (kind == "f") {
      ScanTriangle t{};
      std::size_t place = 0;
      for (std::string_view word = take_word(line); !word.empty(); word = take_word(line), ++place) {
        const auto corner = corner_of(word, scan.points.size());
        if (!corner)
          return bad_scan(what, "line " + std::to_string(number) + " has a corner that is no point's number");
        if (place == 0) t[0] = *corner;
        if (place >= 2) {
          if (scan.triangles.size() == kScanTrianglesMax)
            return bad_scan(what, "it has more than " + std::to_string(kScanTrianglesMax) + " triangles");
          t[1] = t[2];
          t[2] = *corner;
          scan.triangles.push_back(t);
        } else {
          t[2] = *corner;
        }
      }
    }
  }
  return scan;
}

}  // namespace im2fit::hal
