// SPDX-License-Identifier: Apache-2.0
#include "hal/scan/scan_file.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/file.h"
#include "hal/scan/scan_readers.h"

namespace im2fit::hal {
namespace {

using Reader = Result<RawScan> (*)(ScanBytes, const std::string&);
constexpr std::pair<std::string_view, Reader> kReaders[] = {
    {".ply", read_ply}, {".obj", read_obj}, {".glb", read_glb}, {".pcd", read_pcd}};

Reader reader_of(const std::string& path) {
  for (const auto& [ending, reader] : kReaders) {
    if (path.size() <= ending.size()) continue;
    bool same = true;
    for (std::size_t i = 0; i < ending.size(); ++i) {
      const char c = path[path.size() - ending.size() + i];
      same = same && (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) == ending[i];
    }
    if (same) return reader;
  }
  return nullptr;
}

}  // namespace

Result<Scan> checked_scan(RawScan raw, const std::string& what) {
  constexpr std::uint32_t kGone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(raw.points.size(), kGone);
  Scan scan;
  scan.points.reserve(raw.points.size());
  for (std::size_t i = 0; i < raw.points.size(); ++i) {
    const Vec3f p = raw.points[i];
    if (!(std::fabs(p.x) < kScanReach && std::fabs(p.y) < kScanReach && std::fabs(p.z) < kScanReach)) continue;
    place[i] = static_cast<std::uint32_t>(scan.points.size());
    scan.points.push_back(p);
  }
  scan.triangles.reserve(raw.triangles.size());
  for (const ScanTriangle& t : raw.triangles) {
    for (const std::uint32_t corner : t)
      if (corner >= place.size())
        return bad_scan(what, "a face has the corner " + std::to_string(corner) + " of " +
                                  std::to_string(place.size()) + " points");
    const ScanTriangle moved = {place[t[0]], place[t[1]], place[t[2]]};
    if (moved[0] != kGone && moved[1] != kGone && moved[2] != kGone) scan.triangles.push_back(moved);
  }
  if (scan.points.empty()) return bad_scan(what, "it has no points");
  return scan;
}

std::optional<double> decimal_of(std::string_view word) {
  const bool negative = !word.empty() && word.front() == '-';
  if (negative || (!word.empty() && word.front() == '+')) word.remove_prefix(1);
  // As C's and Microsoft's printf write them: nan, NaN, -nan(ind), inf, 1.#QNAN.
  if (word.size() >= 3) {
    std::string name(word.substr(0, 3));
    for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (name == "nan" || name == "inf" || name == "1.#") return std::numeric_limits<double>::quiet_NaN();
  }
  double value = 0;
  std::int64_t places = 0;
  std::size_t at = 0;
  bool digits = false, point = false;
  for (; at < word.size(); ++at) {
    if (word[at] == '.' && !point) {
      point = true;
      continue;
    }
    if (word[at] < '0' || word[at] > '9') break;
    digits = true;
    value = 10 * value + (word[at] - '0');
    places -= point ? 1 : 0;
  }
  if (!digits) return std::nullopt;
  if (at < word.size()) {
    if (word[at] != 'e' && word[at] != 'E') return std::nullopt;
    const auto exponent = number_of<std::int16_t>(word.substr(at + 1));
    if (!exponent) return std::nullopt;
    places += *exponent;
  }
  if (value != 0) value *= std::pow(10.0, static_cast<double>(places));
  return negative ? -value : value;
}

bool is_scan_name(const std::string& path) {
  return reader_of(path) != nullptr;
}

Result<Scan> read_scan(const std::string& path) {
  const Reader reader = reader_of(path);
  if (reader == nullptr)
    return Error{ErrorCode::unsupported, path + " is no scan; expected a name that ends in .ply, .obj, .glb or .pcd"};
  const auto bytes = read_file(path, kScanBytesMax);
  if (!bytes) return bytes.error();
  auto raw = reader(*bytes, path);
  if (!raw) return raw.error();
  return checked_scan(std::move(*raw), path);
}

}  // namespace im2fit::hal
