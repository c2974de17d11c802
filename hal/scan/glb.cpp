// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 in one file (Khronos' specification, "GLB File Format Specification"): triangles and points of the scene's
// meshes, where their nodes put them. A skinned mesh is taken as it rests.
#include <array>
#include <nlohmann/json.hpp>

#include "formats/json_file.h"
#include "hal/scan/scan_readers.h"

namespace im2fit::hal {
namespace {

using Json = nlohmann::json;
using Matrix = std::array<double, 16>;  // columns one after the other, as glTF has them
constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// A body has a mesh or two; the JSON of avatars with a hundred morphs has some 100 kB.
constexpr std::size_t kTreeBytesMax = std::size_t{16} << 20, kPrimitivesMax = 100'000;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t i = 0; i < 4; ++i) out[4 * column + row] += a[4 * i + row] * b[4 * column + i];
  return out;
}

// A member of that kind, a list or an object; an empty one where there is none.
const Json& part(const Json& json, const char* key, Json::value_t kind = Json::value_t::array) {
  static const Json kNone = Json::array();
  if (!json.is_object()) return kNone;
  const auto it = json.find(key);
  return it != json.end() && it->type() == kind ? *it : kNone;
}
std::optional<std::uint64_t> whole(const Json& json) {
  if (json.is_number_unsigned()) return json.get<std::uint64_t>();
  return std::nullopt;
}
std::optional<std::uint64_t> whole(const Json& json, const char* key) {
  if (!json.is_object()) return std::nullopt;
  const auto it = json.find(key);
  return it == json.end() ? std::nullopt : whole(*it);
}
template <std::size_t N>
std::optional<std::array<double, N>> numbers(const Json& json, const char* key) {
  const Json& list = part(json, key);
  if (list.size() != N) return std::nullopt;
  std::array<double, N> out{};
  for (std::size_t i = 0; i < N; ++i) {
    if (!list[i].is_number()) return std::nullopt;
    out[i] = list[i].get<double>();
  }
  return out;
}

Matrix placed(const Json& node) {
  if (const auto matrix = numbers<16>(node, "matrix")) return *matrix;
  const auto shift = numbers<3>(node, "translation").value_or(std::array<double, 3>{0, 0, 0});
  const auto turn = numbers<4>(node, "rotation").value_or(std::array<double, 4>{0, 0, 0, 1});
  const auto scale = numbers<3>(node, "scale").value_or(std::array<double, 3>{1, 1, 1});
  const auto [x, y, z, w] = turn;
  const double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Matrix out = kIdentity;
  for (std::size_t column = 0; column < 3; ++column)
    for (std::size_t row = 0; row < 3; ++row) out[4 * column + row] = rows[row][column] * scale[column];
  for (std::size_t row = 0; row < 3; ++row) out[12 + row] = shift[row];
  return out;
}

class GlbReader {
 public:
  GlbReader(ScanBytes bytes, const std::string& what) : bytes_(bytes), what_(what) {}

  Result<RawScan> read() {
    if (auto ok = find_chunks(); !ok) return ok.error();
    auto json = parse_json(text_of(json_), what_);
    if (!json) return json.error();
    json_tree_ = std::move(*json);
    for (const Json& name : part(json_tree_, "extensionsRequired"))
      if (name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression" ||
          name == "KHR_mesh_quantization")
        return Error{ErrorCode::unsupported, what_ + ": it needs " + name.get<std::string>() +
                                                 ", which is not read; export it without compression"};
    if (auto ok = walk(); !ok) return ok.error();
    return std::move(scan_);
  }

 private:
  Error bad(const std::string& why) const { return bad_scan(what_, why); }

  Status find_chunks() {
    constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;
    if (bytes_.size() < 12 || piece_of<std::uint32_t>(bytes_.data()) != kMagic)
      return bad("it does not begin with \"glTF\"");
    if (const auto version = piece_of<std::uint32_t>(bytes_.data() + 4); version != 2)
      return Error{ErrorCode::unsupported, what_ + ": it is glTF " + std::to_string(version) + ", expected 2"};
    std::size_t at = 12;
    while (bytes_.size() - at >= 8) {
      const std::size_t size = piece_of<std::uint32_t>(bytes_.data() + at);
      const auto kind = piece_of<std::uint32_t>(bytes_.data() + at + 4);
      at += 8;
      if (size > bytes_.size() - at) return bad("a part of it is cut off");
      if (kind == kJson && size > kTreeBytesMax)
        return bad("its JSON part is larger than " + std::to_string(kTreeBytesMax >> 20) + " MB");
      if (kind == kJson && json_.empty()) json_ = bytes_.subspan(at, size);
      if (kind == kBin && bin_.empty()) bin_ = bytes_.subspan(at, size);
      at += size;
    }
    if (json_.empty()) return bad("it has no JSON part");
    return Ok{};
  }

  // Every node under the scene's, each once: glTF has them in trees.
  Status walk() {
    const Json& nodes = part(json_tree_, "nodes");
    const Json& scenes = part(json_tree_, "scenes");
    std::vector<std::pair<std::size_t, Matrix>> open;
    std::vector<bool> seen(nodes.size(), false);
    const auto add = [&](const Json& list, const Matrix& to_scene) {
      for (const Json& entry : list) {
        const auto i = whole(entry);
        if (!i || *i >= nodes.size() || seen[static_cast<std::size_t>(*i)]) continue;
        seen[static_cast<std::size_t>(*i)] = true;
        open.emplace_back(static_cast<std::size_t>(*i), to_scene);
      }
    };
    if (const std::uint64_t scene = whole(json_tree_, "scene").value_or(0); scene < scenes.size())
      add(part(scenes[static_cast<std::size_t>(scene)], "nodes"), kIdentity);
    while (!open.empty()) {
      const auto [i, above] = open.back();
      open.pop_back();
      const Json& node = nodes[i];
      const Matrix to_scene = product(above, placed(node));
      add(part(node, "children"), to_scene);
      const auto mesh = whole(node, "mesh");
      const Json& meshes = part(json_tree_, "meshes");
      if (!mesh || *mesh >= meshes.size()) continue;
      // What a skin moves does not follow its node.
      const Matrix& placing = whole(node, "skin") ? kIdentity : to_scene;
      for (const Json& primitive : part(meshes[static_cast<std::size_t>(*mesh)], "primitives")) {
        if (++primitives_ > kPrimitivesMax)
          return bad("its nodes name more than " + std::to_string(kPrimitivesMax) + " parts of meshes");
        if (auto ok = add_primitive(primitive, placing); !ok) return ok.error();
      }
    }
    return Ok{};
  }

  struct Rows {
    const std::byte* first = nullptr;
    std::size_t count = 0, stride = 0;
    std::uint64_t type = 0;
  };
  // An accessor's values, `size_of(type)` bytes each, all of them within the file.
  Result<Rows> rows(std::uint64_t accessor_number, const char* shape) const {
    const Json& accessors = part(json_tree_, "accessors");
    if (accessor_number >= accessors.size()) return bad("a mesh names an accessor that is not there");
    const Json& accessor = accessors[static_cast<std::size_t>(accessor_number)];
    const auto type = whole(accessor, "componentType");
    const auto count = whole(accessor, "count");
    const auto kind = accessor.find("type");
    if (!type || !count || kind == accessor.end() || *kind != shape)
      return bad("an accessor is not of the kind that a mesh needs");
    if (accessor.contains("sparse"))
      return Error{ErrorCode::unsupported, what_ + ": it has sparse accessors, which are not read; export it anew"};
    const std::size_t part_bytes = *type == 5126 || *type == 5125 ? 4 : *type == 5123 ? 2 : *type == 5121 ? 1 : 0;
    const std::size_t size = part_bytes * (std::string_view(shape) == "VEC3" ? 3 : 1);
    const Json& views = part(json_tree_, "bufferViews");
    const auto view_number = whole(accessor, "bufferView");
    if (size == 0 || !view_number || *view_number >= views.size())
      return bad("an accessor has no values that are known");
    const Json& view = views[static_cast<std::size_t>(*view_number)];
    if (whole(view, "buffer").value_or(0) != 0)
      return Error{ErrorCode::unsupported, what_ + ": its points are in another file; export it as one .glb"};
    const std::uint64_t stride = whole(view, "byteStride").value_or(size);
    const std::uint64_t of_view = whole(view, "byteOffset").value_or(0),
                        of_all = whole(accessor, "byteOffset").value_or(0);
    if (of_view > bin_.size() || of_all > bin_.size()) return bad("an accessor reaches past the file's end");
    const std::uint64_t from = of_view + of_all;
    if (*count == 0 || *count > kScanTrianglesMax || stride < size || stride > 252 || from > bin_.size() ||
        (*count - 1) * stride + size > bin_.size() - from)
      return bad("an accessor reaches past the file's end");
    return Rows{bin_.data() + from, static_cast<std::size_t>(*count), static_cast<std::size_t>(stride), *type};
  }

  Status add_primitive(const Json& primitive, const Matrix& placing) {
    const std::uint64_t mode = whole(primitive, "mode").value_or(4);
    if (mode != 0 && mode != 4)
      return Error{ErrorCode::unsupported, what_ + ": it has strips, fans or lines; export it as triangles"};
    const auto position = whole(part(primitive, "attributes", Json::value_t::object), "POSITION");
    if (!position) return Ok{};
    const auto points = rows(*position, "VEC3");
    if (!points) return points.error();
    if (points->type != 5126) return bad("its positions are not of type float");
    const std::size_t first = scan_.points.size();
    if (points->count > kScanPointsMax - first)
      return bad("it has more than " + std::to_string(kScanPointsMax) + " points");
    for (std::size_t i = 0; i < points->count; ++i) {
      const std::byte* at = points->first + i * points->stride;
      const double p[3] = {static_cast<double>(piece_of<float>(at)), static_cast<double>(piece_of<float>(at + 4)),
                           static_cast<double>(piece_of<float>(at + 8))};
      const auto row = [&](std::size_t r) {
        return static_cast<float>(placing[r] * p[0] + placing[4 + r] * p[1] + placing[8 + r] * p[2] +
                                  placing[12 + r]);
      };
      scan_.points.push_back({row(0), row(1), row(2)});
    }
    if (mode == 0) return Ok{};
    return add_triangles(primitive, first, points->count);
  }

  Status add_triangles(const Json& primitive, std::size_t first, std::size_t point_count) {
    const auto indices = whole(primitive, "indices");
    Rows corners;
    corners.count = point_count;
    if (indices) {
      const auto read = rows(*indices, "SCALAR");
      if (!read) return read.error();
      corners = *read;
      if (corners.type == 5126) return bad("its corners are no whole numbers");
    }
    const auto corner = [&](std::size_t i) -> std::size_t {
      if (!indices) return i;
      const std::byte* at = corners.first + i * corners.stride;
      return corners.type == 5125   ? piece_of<std::uint32_t>(at)
             : corners.type == 5123 ? piece_of<std::uint16_t>(at)
                                    : piece_of<std::uint8_t>(at);
    };
    if (corners.count / 3 > kScanTrianglesMax - scan_.triangles.size())
      return bad("it has more than " + std::to_string(kScanTrianglesMax) + " triangles");
    for (std::size_t i = 0; i + 2 < corners.count; i += 3) {
      ScanTriangle t{};
      for (std::size_t c = 0; c < 3; ++c) {
        if (corner(i + c) >= point_count) return bad("a triangle has a corner that is no point of its mesh");
        t[c] = static_cast<std::uint32_t>(first + corner(i + c));
      }
      scan_.triangles.push_back(t);
    }
    return Ok{};
  }

  ScanBytes bytes_, json_, bin_;
  const std::string& what_;
  Json json_tree_;
  std::size_t primitives_ = 0;
  RawScan scan_;
};

}  // namespace

Result<RawScan> read_glb(ScanBytes bytes, const std::string& what) {
  return GlbReader(bytes, what).read();
}

}  // namespace im2fit::hal
