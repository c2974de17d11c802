// SPDX-License-Identifier: Apache-2.0
// PCD, the point clouds of PCL (pointclouds.org, "The PCD file format", version 0.7): text, binary, and binary
// compressed by LZF field by field.
#include <array>
#include <limits>

#include "hal/scan/scan_readers.h"

namespace im2fit::hal {
namespace {

struct Field {
  std::string_view name;
  std::size_t size = 4, count = 1;
  char type = 'F';
  std::size_t offset = 0;  // in a point's bytes
};

constexpr std::size_t kFieldsMax = 64, kPointBytesMax = 4096;

struct Header {
  std::vector<Field> fields;
  std::size_t points = 0, stride = 0;
  std::string_view data;
  std::array<std::size_t, 3> axes{};  // which of `fields`
  const Field& axis(std::size_t a) const { return fields[axes[a]]; }
};

Result<Header> read_header(std::string_view& text, const std::string& what) {
  Header header;
  std::uint64_t width = 0, height = 1;
  std::optional<std::uint64_t> told;
  const auto per_field = [&](std::string_view line, auto set) {
    for (Field& field : header.fields)
      if (!set(field, take_word(line))) return false;
    return true;
  };
  const auto whole = [](std::string_view word, std::size_t& out) {
    const auto number = number_of<std::uint64_t>(word);
    if (!number || *number == 0 || *number > kPointBytesMax) return false;
    out = static_cast<std::size_t>(*number);
    return true;
  };
  while (header.data.empty()) {
    if (text.empty()) return bad_scan(what, "its header has no line DATA");
    std::string_view line = take_line(text);
    const std::string_view word = take_word(line);
    bool good = true;
    if (word == "FIELDS") {
      for (std::string_view name = take_word(line); !name.empty(); name = take_word(line)) {
        header.fields.push_back({name});
        if (header.fields.size() > kFieldsMax) return bad_scan(what, "it has more than 64 fields");
      }
    } else if (word == "SIZE") {
      good = per_field(line, [&](Field& field, std::string_view w) { return whole(w, field.size); });
    } else if (word == "COUNT") {
      good = per_field(line, [&](Field& field, std::string_view w) { return whole(w, field.count); });
    } else if (word == "TYPE") {
      good = per_field(line, [&](Field& field, std::string_view w) {
        field.type = w.empty() ? ' ' : w.front();
        return w == "F" || w == "I" || w == "U";
      });
    } else if (word == "WIDTH" || word == "HEIGHT" || word == "POINTS") {
      const auto number = number_of<std::uint64_t>(take_word(line));
      good = number && *number <= kScanPointsMax;
      if (good && word == "WIDTH") width = *number;
      if (good && word == "HEIGHT") height = *number;
      if (good && word == "POINTS") told = number;
    } else if (word == "DATA") {
      header.data = take_word(line);
    }
    if (!good) return bad_scan(what, "its header's line " + std::string(word) + " is not as PCD has it");
  }
  const std::uint64_t points = told.value_or(width * height);
  if (points > kScanPointsMax)
    return bad_scan(what, "it has more than " + std::to_string(kScanPointsMax) + " points");
  header.points = static_cast<std::size_t>(points);
  header.axes.fill(header.fields.size());
  for (std::size_t f = 0; f < header.fields.size(); ++f) {
    Field& field = header.fields[f];
    field.offset = header.stride;
    header.stride += field.size * field.count;
    if (header.stride > kPointBytesMax) return bad_scan(what, "its points have more than 4096 bytes each");
    for (std::size_t a = 0; a < 3; ++a)
      if (field.name == std::string_view("xyz").substr(a, 1)) header.axes[a] = f;
  }
  for (const std::size_t f : header.axes)
    if (f == header.fields.size() || header.fields[f].type != 'F' || header.fields[f].count != 1 ||
        (header.fields[f].size != 4 && header.fields[f].size != 8))
      return bad_scan(what, "its points have no x, y and z of type F");
  return header;
}

float coordinate(const Field& field, const std::byte* at) {
  return field.size == 4 ? piece_of<float>(at) : static_cast<float>(piece_of<double>(at));
}

Result<RawScan> read_text(const Header& header, std::string_view text, const std::string& what) {
  if (header.points > text.size()) return bad_scan(what, "it is cut off");
  RawScan scan;
  scan.points.reserve(header.points);
  for (std::size_t i = 0; i < header.points; ++i) {
    std::string_view line = take_line(text);
    Vec3f p{std::numeric_limits<float>::quiet_NaN(), 0, 0};
    float* const out[] = {&p.x, &p.y, &p.z};
    for (const Field& field : header.fields) {
      for (std::size_t c = 0; c < field.count; ++c) {
        const std::string_view word = take_word(line);
        if (word.empty()) return bad_scan(what, "point " + std::to_string(i) + " is cut off");
        for (std::size_t a = 0; a < 3; ++a) {
          if (&field != &header.axis(a)) continue;
          const auto value = decimal_of(word);
          if (!value) return bad_scan(what, "point " + std::to_string(i) + " is no number");
          *out[a] = static_cast<float>(*value);
        }
      }
    }
    scan.points.push_back(p);
  }
  return scan;
}

// LZF (Marc Lehmann's liblzf): literal runs, and copies of what was written up to 8 kB before. False: damaged.
bool unpack_lzf(ScanBytes in, std::span<std::byte> out) {
  std::size_t from = 0, to = 0;
  while (from < in.size()) {
    const auto control = std::to_integer<unsigned>(in[from++]);
    if (control < 32) {
      const std::size_t run = control + 1;
      if (run > in.size() - from || run > out.size() - to) return false;
      std::memcpy(out.data() + to, in.data() + from, run);
      from += run;
      to += run;
      continue;
    }
    std::size_t length = control >> 5U;
    if (length == 7) {
      if (from == in.size()) return false;
      length += std::to_integer<std::size_t>(in[from++]);
    }
    length += 2;
    if (from == in.size()) return false;
    const std::size_t back = ((control & 31U) << 8U) + std::to_integer<std::size_t>(in[from++]) + 1;
    if (back > to || length > out.size() - to) return false;
    for (std::size_t i = 0; i < length; ++i, ++to) out[to] = out[to - back];
  }
  return to == out.size();
}

Result<RawScan> read_binary(const Header& header, ScanBytes bytes, const std::string& what) {
  if (header.points * header.stride > bytes.size()) return bad_scan(what, "it is cut off");
  RawScan scan;
  scan.points.reserve(header.points);
  for (std::size_t i = 0; i < header.points; ++i) {
    const std::byte* at = bytes.data() + i * header.stride;
    scan.points.push_back({coordinate(header.axis(0), at + header.axis(0).offset),
                           coordinate(header.axis(1), at + header.axis(1).offset),
                           coordinate(header.axis(2), at + header.axis(2).offset)});
  }
  return scan;
}

Result<RawScan> read_compressed(const Header& header, ScanBytes bytes, const std::string& what) {
  constexpr std::size_t kGrowthMax = 100;  // LZF makes at most 88 bytes of one
  if (bytes.size() < 8) return bad_scan(what, "it is cut off");
  const std::size_t packed = piece_of<std::uint32_t>(bytes.data());
  const std::size_t size = piece_of<std::uint32_t>(bytes.data() + 4);
  if (packed > bytes.size() - 8) return bad_scan(what, "it is cut off");
  if (size != header.points * header.stride || size > kScanBytesMax || size > kGrowthMax * packed)
    return bad_scan(what, "its compressed size does not fit to its number of points");
  std::vector<std::byte> all(size);
  if (!unpack_lzf(bytes.subspan(8, packed), all)) return bad_scan(what, "its compressed points are damaged");
  RawScan scan;
  scan.points.reserve(header.points);
  const auto value = [&](const Field& field, std::size_t i) {
    return coordinate(field, all.data() + field.offset * header.points + i * field.size);
  };
  for (std::size_t i = 0; i < header.points; ++i)
    scan.points.push_back({value(header.axis(0), i), value(header.axis(1), i), value(header.axis(2), i)});
  return scan;
}

}  // namespace

Result<RawScan> read_pcd(ScanBytes bytes, const std::string& what) {
  std::string_view text = text_of(bytes);
  const auto header = read_header(text, what);
  if (!header) return header.error();
  const ScanBytes rest = bytes.last(text.size());
  if (header->data == "ascii") return read_text(*header, text, what);
  if (header->data == "binary") return read_binary(*header, rest, what);
  if (header->data == "binary_compressed") return read_compressed(*header, rest, what);
  return bad_scan(what, "its DATA is neither ascii nor binary nor binary_compressed");
}

}  // namespace im2fit::hal
