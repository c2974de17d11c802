// SPDX-License-Identifier: Apache-2.0
// PLY as of Greg Turk's text of 1994 and its users since: elements in the order of the header, each of single values
// and lists. Vertices' x, y, z and faces' corners are kept.
#include <array>

#include "hal/scan/scan_readers.h"

namespace im2fit::hal {
namespace {

enum class Format { text, little, big };
enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

constexpr std::pair<std::string_view, Type> kTypes[] = {
    {"char", Type::i8},   {"int8", Type::i8},     {"uchar", Type::u8},   {"uint8", Type::u8},
    {"short", Type::i16}, {"int16", Type::i16},   {"ushort", Type::u16}, {"uint16", Type::u16},
    {"int", Type::i32},   {"int32", Type::i32},   {"uint", Type::u32},   {"uint32", Type::u32},
    {"float", Type::f32}, {"float32", Type::f32}, {"double", Type::f64}, {"float64", Type::f64},
};

std::optional<Type> type_of(std::string_view word) {
  for (const auto& [name, type] : kTypes)
    if (name == word) return type;
  return std::nullopt;
}

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string_view name;
  Type type = Type::f32;
  std::optional<Type> count;  // of a list
};
struct Element {
  std::string_view name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  PlyReader(ScanBytes bytes, const std::string& what) : text_(text_of(bytes)), what_(what) {}

  Result<RawScan> read() {
    if (auto ok = read_header(); !ok) return ok.error();
    for (const Element& element : elements_) {
      if (element.count == 0 || (element.properties.empty() && element.name != "vertex" && element.name != "face"))
        continue;
      const Status ok = element.name == "vertex" ? read_vertices(element)
                        : element.name == "face" ? read_faces(element)
                                                 : pass(element);
      if (!ok) return ok.error();
    }
    return std::move(scan_);
  }

 private:
  Error bad(const std::string& why) const { return bad_scan(what_, why); }

  Status read_header() {
    if (take_line(text_) != "ply") return bad("it does not begin with the line \"ply\"");
    bool has_format = false;
    for (;;) {
      if (text_.empty()) return bad("its header has no line \"end_header\"");
      std::string_view line = take_line(text_);
      const std::string_view word = take_word(line);
      if (word == "end_header") break;
      if (word == "comment" || word == "obj_info" || word.empty()) continue;
      if (word == "format") {
        const std::string_view format = take_word(line);
        format_ = format == "ascii" ? Format::text : format == "binary_little_endian" ? Format::little : Format::big;
        has_format = format_ != Format::big || format == "binary_big_endian";
        continue;
      }
      const Status ok =
          word == "element" ? read_element(line)
          : word == "property"
              ? read_property(line)
              : Status(bad("its header has a line \"" + std::string(word.substr(0, 40)) + "\", which PLY has not"));
      if (!ok) return ok.error();
    }
    if (!has_format) return bad("its header has no format that is known");
    return Ok{};
  }

  Status read_element(std::string_view line) {
    Element element;
    element.name = take_word(line);
    const auto count = number_of<std::uint64_t>(take_word(line));
    // Each takes a byte at least, so that a header alone fills no memory.
    if (!count || *count > kScanTrianglesMax || *count > text_.size())
      return bad("the count of its element \"" + std::string(element.name.substr(0, 40)) +
                 "\" does not fit to the file's size, or is larger than " + std::to_string(kScanTrianglesMax));
    element.count = static_cast<std::size_t>(*count);
    elements_.push_back(std::move(element));
    return Ok{};
  }

  Status read_property(std::string_view line) {
    if (elements_.empty()) return bad("its header has a property before any element");
    Property property;
    std::string_view word = take_word(line);
    if (word == "list") {
      property.count = type_of(take_word(line));
      if (!property.count) return bad("a list's count has a type that is not known");
      word = take_word(line);
    }
    const auto type = type_of(word);
    if (!type) return bad("a property has the type \"" + std::string(word.substr(0, 40)) + "\", which PLY has not");
    property.type = *type;
    property.name = take_word(line);
    elements_.back().properties.push_back(property);
    return Ok{};
  }

  // The next value; none where the file ends.
  std::optional<double> value(Type type) {
    if (format_ == Format::text) return decimal_of(take_word(text_));
    const std::size_t size = size_of(type);
    if (text_.size() < size) return std::nullopt;
    const auto* at = reinterpret_cast<const std::byte*>(text_.data());
    const bool big = format_ == Format::big;
    text_.remove_prefix(size);
    switch (type) {
      case Type::i8:
        return static_cast<double>(piece_of<std::int8_t>(at));
      case Type::u8:
        return static_cast<double>(piece_of<std::uint8_t>(at));
      case Type::i16:
        return static_cast<double>(piece_of<std::int16_t>(at, big));
      case Type::u16:
        return static_cast<double>(piece_of<std::uint16_t>(at, big));
      case Type::i32:
        return static_cast<double>(piece_of<std::int32_t>(at, big));
      case Type::u32:
        return static_cast<double>(piece_of<std::uint32_t>(at, big));
      case Type::f32:
        return static_cast<double>(piece_of<float>(at, big));
      case Type::f64:
        break;
    }
    return piece_of<double>(at, big);
  }

  Error ends(const Element& element, std::size_t i) const {
    return bad(std::string(element.name.substr(0, 40)) + " " + std::to_string(i) + " of " +
               std::to_string(element.count) + " is cut off or no number");
  }

  // Every value of one element, lists with their counts; visit(property, value, place in its list).
  template <class Visit>
  bool take(const Element& element, Visit visit) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      std::size_t count = 1;
      if (property.count) {
        const auto told = value(*property.count);
        if (!told || !(*told >= 0) || *told > static_cast<double>(text_.size())) return false;
        count = static_cast<std::size_t>(*told);
      }
      for (std::size_t i = 0; i < count; ++i) {
        const auto read = value(property.type);
        if (!read) return false;
        visit(p, *read, i);
      }
    }
    return true;
  }

  Status pass(const Element& element) {
    for (std::size_t i = 0; i < element.count; ++i)
      if (!take(element, [](std::size_t, double, std::size_t) {})) return ends(element, i);
    return Ok{};
  }

  Status read_vertices(const Element& element) {
    if (element.count > kScanPointsMax - scan_.points.size())
      return bad("it has more than " + std::to_string(kScanPointsMax) + " points");
    std::array<std::size_t, 3> axis{};
    for (std::size_t a = 0; a < axis.size(); ++a) {
      axis[a] = element.properties.size();
      for (std::size_t p = 0; p < element.properties.size(); ++p)
        if (element.properties[p].name == std::string_view("xyz").substr(a, 1) && !element.properties[p].count)
          axis[a] = p;
      if (axis[a] == element.properties.size()) return bad("its vertices have no x, y and z");
    }
    scan_.points.reserve(scan_.points.size() + element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      std::array<float, 3> at{};
      const bool whole = take(element, [&](std::size_t p, double read, std::size_t) {
        for (std::size_t a = 0; a < axis.size(); ++a)
          if (p == axis[a]) at[a] = static_cast<float>(read);
      });
      if (!whole) return ends(element, i);
      scan_.points.push_back({at[0], at[1], at[2]});
    }
    return Ok{};
  }

  Status read_faces(const Element& element) {
    std::size_t corners = element.properties.size();
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      if (const std::string_view name = element.properties[p].name;
          element.properties[p].count && (name == "vertex_indices" || name == "vertex_index"))
        corners = p;
    if (corners == element.properties.size()) return bad("its faces have no list vertex_indices");
    for (std::size_t i = 0; i < element.count; ++i) {
      ScanTriangle t{};
      bool fits = true;
      const bool whole = take(element, [&](std::size_t p, double read, std::size_t place) {
        if (p != corners) return;
        fits = fits && read >= 0 && read < static_cast<double>(kScanPointsMax);
        const auto corner = fits ? static_cast<std::uint32_t>(read) : 0U;
        if (place == 0) t[0] = corner;
        if (place >= 2) {
          t[1] = t[2];
          t[2] = corner;
          if (scan_.triangles.size() <= kScanTrianglesMax) scan_.triangles.push_back(t);
        } else {
          t[2] = corner;
        }
      });
      if (!whole) return ends(element, i);
      if (!fits) return bad("face " + std::to_string(i) + " has a corner that is no point's number");
      if (scan_.triangles.size() > kScanTrianglesMax)
        return bad("it has more than " + std::to_string(kScanTrianglesMax) + " triangles");
    }
    return Ok{};
  }

  std::string_view text_;
  const std::string& what_;
  Format format_ = Format::text;
  std::vector<Element> elements_;
  RawScan scan_;
};

}  // namespace

Result<RawScan> read_ply(ScanBytes bytes, const std::string& what) {
  return PlyReader(bytes, what).read();
}

}  // namespace im2fit::hal
