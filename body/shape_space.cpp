// SPDX-License-Identifier: Apache-2.0
#include "body/shape_space.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "body/model_data.h"
#include "body/shape_tiles.h"
#include "core/crc32c.h"

namespace im2fit::body {
namespace {

// Records of the file, little-endian. A plane is the mean or one component: `point_count` x kPointValues steps.
struct AboutRecord {
  std::uint32_t point_count = 0;
  std::uint32_t shape_count = 0;
};
struct PlaneScale {  // mm a step
  float middle = 0;
  float diagonal = 0;
};
constexpr std::string_view kSectionPrefix = "shape_";
constexpr float kStepMax = 32767;
constexpr float kWeightSumOff = 1e-3F;  // of four float32 weights, each rounded once

float scale_of(const PlaneScale& scale, std::size_t value) {
  return value < 3 ? scale.middle : scale.diagonal;
}

// 0, or a size that no machine takes for 0 and that no sum of kShapeMax products takes out of range.
bool sane(float v, float limit) {
  return v == 0 || (std::fabs(v) > 1e-18F && std::fabs(v) < limit);
}

bool skin_ok(const SkinRecord& s) {
  float sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (s.segment[i] >= kSegmentCount || !(s.weight[i] >= 0) || !sane(s.weight[i], 2)) return false;
    sum += s.weight[i];
  }
  return std::fabs(sum - 1) <= kWeightSumOff;
}

// Values of a plane lie `shape_count` apart in the basis, next to each other in the mean.
struct Plane {
  std::size_t number, first, stride;
  Plane(std::size_t plane, std::size_t shape_count)
      : number(plane), first(plane == 0 ? 0 : plane - 1), stride(plane == 0 ? 1 : shape_count) {}
  std::size_t operator()(std::size_t value) const { return first + value * stride; }
};

auto& points_of(auto& space, const Plane& plane) {
  return plane.number == 0 ? space.point_mean : space.point_basis;
}
auto& bones_of(auto& space, const Plane& plane) {
  return plane.number == 0 ? space.bone_mean : space.bone_basis;
}

struct Sections {
  std::span<const AboutRecord> about;
  std::span<const PlaneScale> scales;
  std::span<const std::int16_t> points;
  std::span<const SkinRecord> skin;
  std::span<const float> bones;
};

Result<Sections> read_sections(const ContainerReader& reader, const std::string& what) {
  const auto bad = [&](const char* section, const std::string& why) {
    return Error{ErrorCode::corrupt, what + ": section '" + section + "': " + why};
  };
  Sections s;
  if (const auto status = reader.take("shape_about", s.about, 1); !status) return status.error();
  const std::size_t points = s.about[0].point_count, shapes = s.about[0].shape_count;
  if (points < kShapePointMin || points > kShapePointMax)
    return bad("shape_about", std::to_string(points) + " points, expected " + std::to_string(kShapePointMin) +
                                  " to " + std::to_string(kShapePointMax));
  if (shapes < 1 || shapes > kShapeMax)
    return bad("shape_about", std::to_string(shapes) + " shapes, expected 1 to " + std::to_string(kShapeMax));
  const std::size_t planes = 1 + shapes;
  if (const auto status = reader.take("shape_scales", s.scales, planes); !status) return status.error();
  if (const auto status = reader.take("shape_points", s.points, planes * points * kPointValues); !status)
    return status.error();
  if (const auto status = reader.take("shape_skin", s.skin, points); !status) return status.error();
  if (const auto status = reader.take("shape_bones", s.bones, planes * kBoneValues); !status) return status.error();
  for (const PlaneScale& scale : s.scales)
    if (!(scale.middle >= 0 && scale.diagonal >= 0) || !sane(scale.middle, 1) || !sane(scale.diagonal, 1))
      return bad("shape_scales", "a scale is not 0 to 1 mm a step");
  if (!std::all_of(s.skin.begin(), s.skin.end(), skin_ok))
    return bad("shape_skin", "segment or weight out of range, or weights that do not sum to 1");
  if (!std::all_of(s.bones.begin(), s.bones.end(), [](float v) { return sane(v, 1e5F); }))
    return bad("shape_bones", "a value is not a finite position");
  return s;
}

// As reserve(), of values that will be appended. The system makes the pages of a large array in one go where it can,
// at a tenth of the cost of a fault for each.
void make_room(std::vector<float>& values, std::size_t count) {
  values.reserve(count);
#ifdef MADV_POPULATE_WRITE
  constexpr std::size_t kPage = 4096;  // of larger pages the call fails, and faults make them
  auto* const first = reinterpret_cast<std::byte*>(values.data());
  const std::size_t skipped = (kPage - reinterpret_cast<std::uintptr_t>(first) % kPage) % kPage;
  const std::size_t bytes = count * sizeof(float);
  if (bytes > skipped + kPage)
    (void)::madvise(first + skipped, (bytes - skipped) / kPage * kPage, MADV_POPULATE_WRITE);
#endif
}

ShapeSpace empty_space(std::size_t points, std::size_t shapes) {
  ShapeSpace space;
  space.point_count = points;
  space.shape_count = shapes;
  space.point_mean.resize(points * kPointValues);
  make_room(space.point_basis, points * kPointValues * shapes);
  space.bone_mean.resize(kBoneValues);
  space.bone_basis.resize(kBoneValues * shapes);
  return space;
}

bool whole(const ShapeSpace& s) {
  const auto finite = [](const std::vector<float>& values, std::size_t count) {
    return values.size() == count &&
           std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
  };
  return finite(s.point_mean, s.point_count * kPointValues) &&
         finite(s.point_basis, s.point_count * kPointValues * s.shape_count) && s.skin.size() == s.point_count &&
         finite(s.bone_mean, kBoneValues) && finite(s.bone_basis, kBoneValues * s.shape_count);
}

// The file has plane after plane, the basis the planes of a value side by side. They are appended: zeros written
// first would cost as much.
void read_points(const Sections& sections, ShapeSpace& space) {
  const std::size_t point_values = space.point_count * kPointValues, shapes = space.shape_count;
  std::array<std::array<float, kShapeMax>, 2> scales{};  // of middles, of diagonals
  for (std::size_t shape = 0; shape < shapes; ++shape)
    for (std::size_t kind = 0; kind < scales.size(); ++kind)
      scales[kind][shape] = scale_of(sections.scales[1 + shape], 3 * kind);
  const auto scale_at = [&](std::size_t value) { return scales[value % kPointValues < 3 ? 0 : 1].data(); };
  const std::int16_t* const basis = sections.points.data() + point_values;
  for (std::size_t i = 0; i < point_values; ++i)
    space.point_mean[i] = static_cast<float>(sections.points[i]) * scale_of(sections.scales[0], i % kPointValues);
  std::array<float, kShapeTile * kShapeMax> rows;  // of kShapeTile values
  for (std::size_t i = 0; i < point_values; i += kShapeTile) {
    const std::size_t values = std::min(kShapeTile, point_values - i);
    std::array<const float*, kShapeTile> scale{};
    for (std::size_t v = 0; v < values; ++v) scale[v] = scale_at(i + v);
    if (values == kShapeTile)
      unpack_tiles(basis + i, point_values, shapes, scale, rows.data());
    else
      for (std::size_t v = 0; v < values; ++v)
        for (std::size_t p = 0; p < shapes; ++p)
          rows[v * shapes + p] = static_cast<float>(basis[p * point_values + i + v]) * scale[v][p];
    space.point_basis.insert(space.point_basis.end(), rows.begin(),
                             rows.begin() + static_cast<std::ptrdiff_t>(values * shapes));
  }
}

PlaneScale largest_over_steps(const std::vector<float>& values, const Plane& plane, std::size_t count) {
  std::array<float, 2> largest{};
  for (std::size_t i = 0; i < count; ++i) {
    float& kind = largest[i % kPointValues < 3 ? 0 : 1];
    kind = std::max(kind, std::fabs(values[plane(i)]));
  }
  return {largest[0] / kStepMax, largest[1] / kStepMax};
}

}  // namespace

Result<ShapeSpace> read_shape_space(const ContainerReader& reader, const std::string& what) {
  if (!reader.entries().contains("shape_about")) return ShapeSpace{};
  const auto sections = read_sections(reader, what);
  if (!sections) return sections.error();
  const AboutRecord& about = sections->about[0];
  ShapeSpace space = empty_space(about.point_count, about.shape_count);
  space.skin.assign(sections->skin.begin(), sections->skin.end());
  std::vector<std::uint32_t> sums;
  for (const auto& [name, entry] : reader.entries())
    if (name.starts_with(kSectionPrefix)) sums.push_back(entry.crc);
  space.key = crc32c(std::as_bytes(std::span(sums)));
  read_points(*sections, space);
  for (std::size_t p = 0; p <= space.shape_count; ++p) {
    const Plane plane(p, space.shape_count);
    auto& bones = bones_of(space, plane);
    for (std::size_t i = 0; i < kBoneValues; ++i) bones[plane(i)] = sections->bones[p * kBoneValues + i];
  }
  return space;
}

Result<std::vector<std::byte>> with_shape_space(std::span<const std::byte> pack, const ShapeSpace& space) {
  const auto reader = ContainerReader::parse(pack, kBodyMagic, kBodyVersion, "body file");
  if (!reader) return reader.error();
  if (!whole(space))
    return Error{ErrorCode::invalid_argument, "shape space: " + std::to_string(space.point_count) + " points of " +
                                                  std::to_string(space.shape_count) +
                                                  " shapes, but arrays of other sizes or values that are not finite"};
  ContainerWriter writer(kBodyMagic, kBodyVersion);
  for (const auto& [name, entry] : reader->entries()) {
    if (name.starts_with(kSectionPrefix)) continue;
    const auto section = *reader->section(name);
    writer.add(name, {section.begin(), section.end()});
  }
  const AboutRecord about = {static_cast<std::uint32_t>(space.point_count),
                             static_cast<std::uint32_t>(space.shape_count)};
  std::vector<PlaneScale> scales;
  std::vector<std::int16_t> points;
  std::vector<float> bones;
  const std::size_t point_values = space.point_count * kPointValues;
  for (std::size_t p = 0; p <= space.shape_count; ++p) {
    const Plane plane(p, space.shape_count);
    const auto& values = points_of(space, plane);
    scales.push_back(largest_over_steps(values, plane, point_values));
    for (std::size_t i = 0; i < point_values; ++i) {
      const float scale = scale_of(scales.back(), i % kPointValues);
      const float steps = scale > 0 ? values[plane(i)] / scale : 0;
      points.push_back(static_cast<std::int16_t>(std::lround(std::clamp(steps, -kStepMax, kStepMax))));
    }
    for (std::size_t i = 0; i < kBoneValues; ++i) bones.push_back(bones_of(space, plane)[plane(i)]);
  }
  writer.add_array<AboutRecord>("shape_about", std::span(&about, 1));
  writer.add_array<PlaneScale>("shape_scales", scales);
  writer.add_array<std::int16_t>("shape_points", points);
  writer.add_array<SkinRecord>("shape_skin", space.skin);
  writer.add_array<float>("shape_bones", bones);
  auto bytes = writer.finish();
  const auto written = ContainerReader::parse(bytes, kBodyMagic, kBodyVersion, "body file", false);
  if (!written) return written.error();
  if (const auto checked = read_shape_space(*written, "shape space"); !checked) return checked.error();
  return bytes;
}

}  // namespace im2fit::body
