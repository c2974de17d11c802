// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/other_mesh.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <unordered_set>

#include "body/skeleton.h"
#include "core/file.h"

namespace im2fit::lab {
namespace {

// Of the file: its man is turned to his right by this (shoulders 6.3, hips 7.8 degrees, ankles more).
constexpr float kYawDeg = 6.9F;
constexpr float kSolesMm = -888.102F;  // its lowest vertex
constexpr float kMiddleMm = -2.5F;     // x of its hips' middle

// What the file's extent must be: a standing man of 1,758 mm.
constexpr float kStatureMinMm = 1700, kStatureMaxMm = 1820;

// Words of a line, separated by blanks.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    const std::size_t from = rest_.find_first_not_of(" \t\r");
    if (from == std::string_view::npos) return {};
    rest_.remove_prefix(from);
    const std::size_t length = std::min(rest_.find_first_of(" \t\r"), rest_.size());
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }

 private:
  std::string_view rest_;
};

template <class Number>
bool parse(std::string_view word, Number& out) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc() && end == word.data() + word.size();
}

Error bad(const std::string& file, const std::string& what) {
  return Error{ErrorCode::corrupt, fmt::format("{}: {}", file, what)};
}

Status read_line(std::string_view line, const std::string& file, std::size_t number, OtherMesh& mesh) {
  Words words(line);
  const std::string_view kind = words.next();
  if (kind == "v") {
    std::array<float, 3> p{};
    for (float& x : p)
      if (!parse(words.next(), x) || !std::isfinite(x))
        return bad(file, fmt::format("line {}: a vertex needs three finite coordinates", number));
    mesh.vertices.push_back({p[0], p[1], p[2]});
  } else if (kind == "f") {
    std::array<std::int32_t, 3> t{};
    for (std::int32_t& i : t) {
      const std::string_view word = words.next();
      if (!parse(word.substr(0, word.find('/')), i))
        return bad(file, fmt::format("line {}: a triangle needs three vertex numbers", number));
      if (i < 1 || static_cast<std::size_t>(i) > kOtherVertexCount)
        return bad(file, fmt::format("line {}: vertex {} of 1..{}", number, i, kOtherVertexCount));
      --i;
    }
    if (!words.next().empty()) return bad(file, fmt::format("line {}: a face of more than three vertices", number));
    mesh.triangles.push_back(t);
  }
  return Ok{};
}

// Every edge is passed once in either direction.
bool closed(const OtherMesh& mesh) {
  std::unordered_set<std::uint64_t> edges;
  const auto key = [](std::int32_t a, std::int32_t b) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32) | static_cast<std::uint32_t>(b);
  };
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (t[i] == t[(i + 1) % 3] || !edges.insert(key(t[i], t[(i + 1) % 3])).second) return false;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (!edges.contains(key(t[(i + 1) % 3], t[i]))) return false;
  return true;
}

double volume_mm3(const OtherMesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
    six += static_cast<double>(dot(at(0), cross(at(1), at(2))));
  }
  return six / 6;
}

}  // namespace

Vec3f placed_as_read(Vec3f in_file) {
  const Vec3f p = {in_file.x - kMiddleMm, in_file.y - kSolesMm, in_file.z};
  return body::rotation_about({0, 1, 0}, kYawDeg) * p;
}

Result<OtherMesh> read_other_mesh(const std::string& file) {
  const auto bytes = read_file(file);
  if (!bytes)
    return Error{bytes.error().code, bytes.error().message +
                                         " (people of the family other are made from s-scape_male.obj, which lies "
                                         "beside the checkout: give its folder by --other)"};
  OtherMesh mesh;
  std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (auto ok = read_line(text.substr(0, end), file, number, mesh); !ok) return ok.error();
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (mesh.vertices.size() != kOtherVertexCount || mesh.triangles.size() != kOtherTriangleCount)
    return bad(file, fmt::format("{} vertices and {} triangles, expected {} and {}", mesh.vertices.size(),
                                 mesh.triangles.size(), kOtherVertexCount, kOtherTriangleCount));
  float low = mesh.vertices[0].y, high = low;
  for (const Vec3f& p : mesh.vertices) low = std::min(low, p.y), high = std::max(high, p.y);
  if (high - low < kStatureMinMm || high - low > kStatureMaxMm || std::fabs(low - kSolesMm) > 5)
    return bad(file, fmt::format("from {:.0f} to {:.0f} along y, expected a man of 1,758 mm from {:.0f} up", low,
                                 high, kSolesMm));
  if (!closed(mesh)) return bad(file, "not a closed surface");
  if (volume_mm3(mesh) <= 0) return bad(file, "triangles face inwards");
  for (Vec3f& p : mesh.vertices) p = placed_as_read(p);
  return mesh;
}

std::string default_other_folder() {
  const char* shared = std::getenv("IM2FIT_SHARED");
  return (shared != nullptr ? std::string(shared) : std::string("../shared")) + "/data/other-makes";
}

std::string other_mesh_file(const std::string& folder) {
  return folder + "/s-scape_male.obj";
}

}  // namespace im2fit::lab
