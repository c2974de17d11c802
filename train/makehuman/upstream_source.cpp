// SPDX-License-Identifier: Apache-2.0
// A checkout of makehumancommunity/makehuman: base.obj, *.target (text), default.mhskel, default_weights.mhw.
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "core/file.h"
#include "formats/json_file.h"
#include "train/makehuman/source.h"

namespace im2fit::body::makehuman {
namespace {

// Splits text into lines and lines into words without copying.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    const auto begin = rest_.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    const auto end = rest_.find_first_of(" \t\r", begin);
    const auto word = rest_.substr(begin, end == std::string_view::npos ? end : end - begin);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end);
    return word;
  }

 private:
  std::string_view rest_;
};

template <class F>
bool for_each_line(std::string_view text, F&& f) {
  while (!text.empty()) {
    const auto end = text.find('\n');
    if (!f(text.substr(0, end))) return false;
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return true;
}

template <class T>
bool to_number(std::string_view word, T& out) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc() && end == word.data() + word.size();
}

class UpstreamSource : public Source {
 public:
  Status open(const std::string& data) {
    data_ = data;
    Status status = read_base(data + "/3dobjs/base.obj");
    if (!status) return status;
    files_read.push_back(data + "/rigs/default.mhskel");
    auto rig_read = read_rig(files_read.back());
    if (!rig_read) return rig_read.error();
    rig = std::move(*rig_read);
    return read_weights(data + "/rigs/default_weights.mhw");
  }

  Result<DenseTarget> target(const TargetName& name) const override {
    const std::string path = data_ + "/targets/" + name.upstream + ".target";
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return DenseTarget{};
    files_read.push_back(path);
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    DenseTarget rows(static_cast<std::size_t>(kSourceVertexCount));
    std::size_t line_number = 0;
    const bool ok = for_each_line(text(*bytes), [&](std::string_view line) {
      ++line_number;
      return read_row(line, rows);
    });
    if (!ok)
      return Error{ErrorCode::corrupt, path + ":" + std::to_string(line_number) + ": expected 'vertex dx dy dz'"};
    return rows;
  }

 private:
  static std::string_view text(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  static bool read_row(std::string_view line, DenseTarget& rows) {
    Words words(line);
    const auto first = words.next();
    if (first.empty() || first[0] == '#') return true;
    int vertex = 0;
    if (!to_number(first, vertex) || vertex < 0 || vertex >= kSourceVertexCount) return false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double delta_dm = 0;
      if (!to_number(words.next(), delta_dm) || !(std::fabs(delta_dm) < 32)) return false;
      rows[static_cast<std::size_t>(vertex)][axis] = static_cast<std::int16_t>(std::lround(delta_dm * 1e3));
    }
    return true;
  }

  Status read_base(const std::string& path) {
    files_read.push_back(path);
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    std::vector<std::array<std::int32_t, 4>>* group = nullptr;
    std::vector<std::array<std::int32_t, 4>>* corner = nullptr;
    std::size_t line_number = 0;
    const bool ok = for_each_line(text(*bytes), [&](std::string_view line) {
      ++line_number;
      Words words(line);
      const auto kind = words.next();
      if (kind == "v") return read_vertex(words);
      if (kind == "vt") return read_texture(words);
      if (kind == "g") {
        const std::string name(words.next());
        group = &groups[name];
        corner = &corners[name];
      }
      if (kind == "f") return group != nullptr && read_face(words, *group, *corner);
      return true;
    });
    if (!ok) return Error{ErrorCode::corrupt, path + ":" + std::to_string(line_number) + ": bad vertex or face"};
    if (base_dm.size() != static_cast<std::size_t>(kSourceVertexCount))
      return Error{ErrorCode::corrupt, path + ": " + std::to_string(base_dm.size()) + " vertices, expected " +
                                           std::to_string(kSourceVertexCount)};
    return Ok{};
  }

  bool read_vertex(Words& words) {
    std::array<double, 3> v{};
    for (double& c : v)
      if (!to_number(words.next(), c)) return false;
    base_dm.push_back(v);
    return true;
  }

  bool read_texture(Words& words) {
    TextureCorner place{};
    for (float& c : place)
      if (!to_number(words.next(), c)) return false;
    texture.push_back(place);
    return true;
  }

  // "vertex/texture" four times; both count from 1.
  bool read_face(Words& words, std::vector<std::array<std::int32_t, 4>>& group,
                 std::vector<std::array<std::int32_t, 4>>& corner) const {
    std::array<std::int32_t, 4> quad{}, places{};
    for (std::size_t i = 0; i < 4; ++i) {
      const auto word = words.next();
      const auto slash = word.find('/');
      if (slash == std::string_view::npos) return false;
      if (!to_number(word.substr(0, slash), quad[i]) || quad[i] < 1 || quad[i] > kSourceVertexCount) return false;
      const auto place = word.substr(slash + 1);
      if (!to_number(place.substr(0, place.find('/')), places[i]) || places[i] < 1 ||
          static_cast<std::size_t>(places[i]) > texture.size())
        return false;
      --quad[i];
      --places[i];
    }
    group.push_back(quad);
    corner.push_back(places);
    return true;
  }

  Status read_weights(const std::string& path) {
    files_read.push_back(path);
    const auto json = read_json(path);
    if (!json) return json.error();
    const auto bad = [&](const std::string& why) { return Error{ErrorCode::corrupt, path + ": " + why}; };
    if (!json->is_object() || !json->contains("weights")) return bad("expected an object 'weights'");
    influences.resize(static_cast<std::size_t>(kSourceVertexCount));
    for (const auto& [bone, rows] : (*json)["weights"].items())
      for (const auto& row : rows) {
        if (!row.is_array() || row.size() != 2 || !row[0].is_number_integer() || !row[1].is_number())
          return bad("bone '" + bone + "': expected [vertex, weight] pairs");
        const auto vertex = row[0].get<std::int64_t>();
        if (vertex < 0 || vertex >= kSourceVertexCount) return bad("bone '" + bone + "': vertex out of range");
        influences[static_cast<std::size_t>(vertex)].emplace_back(bone, row[1].get<double>());
      }
    return Ok{};
  }

  std::string data_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_upstream_checkout(const std::string& data) {
  auto source = std::make_unique<UpstreamSource>();
  const Status status = source->open(data);
  if (!status) return status.error();
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace im2fit::body::makehuman
