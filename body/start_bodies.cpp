// SPDX-License-Identifier: Apache-2.0
#include "body/start_bodies.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "body/model_data.h"
#include "body/params_vector.h"

namespace im2fit::body {
namespace {

struct AboutRecord {
  std::uint32_t man_count = 0;
  std::uint32_t woman_count = 0;
};
constexpr std::string_view kSectionPrefix = "start_";
constexpr std::size_t kStartMax = 4096;
constexpr float kStepMax = 32767;
constexpr float kAgeMax = 90;  // years
constexpr float kValueMax = 1e5F;

// Sliders reach 1, modifiers kModifierLimit; a warp stays well below.
float largest_in(std::size_t column) {
  return column == kAgeParam ? kAgeMax : kModifierLimit;
}

}  // namespace

Params StartBodies::params(std::size_t start) const {
  std::vector<float> row(params_vector_size(modifier_count));
  for (std::size_t c = 0; c < columns.size(); ++c)
    row[columns[c].column] = static_cast<float>(steps[start * columns.size() + c]) * columns[c].scale;
  return unpack_params(row);
}

Result<StartBodies> read_start_bodies(const ContainerReader& reader, std::size_t modifier_count,
                                      const std::string& what) {
  if (!reader.entries().contains("start_about")) return StartBodies{};
  const auto bad = [&](const char* section, const char* why) {
    return Error{ErrorCode::corrupt, what + ": section '" + section + "': " + why};
  };
  std::span<const AboutRecord> about;
  if (const auto status = reader.take("start_about", about, 1); !status) return status.error();
  const std::size_t men = about[0].man_count, women = about[0].woman_count;
  if (men < 1 || men > kStartMax || women < 1 || women > kStartMax)
    return bad("start_about", "not 1 to 4096 start bodies of each sex");
  StartBodies starts;
  starts.man_count = men;
  starts.modifier_count = modifier_count;
  if (const auto status = reader.take("start_columns", starts.columns); !status) return status.error();
  if (const auto status = reader.take("start_steps", starts.steps, (men + women) * starts.columns.size()); !status)
    return status.error();
  if (const auto status = reader.take("start_measured", starts.measured, men + women); !status) return status.error();
  std::size_t free = 0;
  for (const StartColumn& c : starts.columns) {
    if (c.column < free || c.column >= params_vector_size(modifier_count))
      return bad("start_columns", "columns out of range or not rising");
    if (!(c.scale >= 0 && c.scale * kStepMax <= largest_in(c.column) * 1.001F))
      return bad("start_columns", "a scale out of range");
    free = c.column + std::size_t{1};
  }
  for (const MeasurementValues& values : starts.measured)
    for (const float v : values)
      if (!(v > 0 && v < kValueMax)) return bad("start_measured", "a measurement that is not positive and finite");
  return starts;
}

Result<std::vector<std::byte>> with_start_bodies(std::span<const std::byte> pack, std::span<const StartBody> men,
                                                 std::span<const StartBody> women) {
  const auto reader = ContainerReader::parse(pack, kBodyMagic, kBodyVersion, "body file");
  if (!reader) return reader.error();
  const auto modifiers = reader->section("modifiers");
  if (!modifiers) return modifiers.error();
  const std::size_t modifier_count = modifiers->size() / sizeof(ModifierRecord);
  ContainerWriter writer(kBodyMagic, kBodyVersion);
  for (const auto& [name, entry] : reader->entries()) {
    if (name.starts_with(kSectionPrefix)) continue;
    const auto section = *reader->section(name);
    writer.add(name, {section.begin(), section.end()});
  }
  const AboutRecord about = {static_cast<std::uint32_t>(men.size()), static_cast<std::uint32_t>(women.size())};
  std::vector<std::vector<float>> rows;
  std::vector<MeasurementValues> measured;
  for (const auto& sex : {men, women})
    for (const StartBody& body : sex) {
      rows.push_back(pack_params(body.params, modifier_count));
      measured.push_back(body.measured);
      for (std::size_t c = 0; c < rows.back().size(); ++c)
        rows.back()[c] = std::clamp(rows.back()[c], -largest_in(c), largest_in(c));
    }
  std::vector<StartColumn> columns;
  for (std::size_t c = 0; c < params_vector_size(modifier_count); ++c) {
    float largest = 0;
    for (const auto& row : rows) largest = std::max(largest, std::fabs(row[c]));
    if (largest > 0) columns.push_back({static_cast<std::uint32_t>(c), largest / kStepMax});
  }
  std::vector<std::int16_t> steps;
  for (const auto& row : rows)
    for (const StartColumn& c : columns)
      steps.push_back(static_cast<std::int16_t>(std::lround(row[c.column] / c.scale)));
  writer.add_array<AboutRecord>("start_about", std::span(&about, 1));
  writer.add_array<StartColumn>("start_columns", columns);
  writer.add_array<std::int16_t>("start_steps", steps);
  writer.add_array<MeasurementValues>("start_measured", measured);
  auto bytes = writer.finish();
  const auto written = ContainerReader::parse(bytes, kBodyMagic, kBodyVersion, "body file", false);
  if (!written) return written.error();
  if (const auto checked = read_start_bodies(*written, modifier_count, "start bodies"); !checked)
    return checked.error();
  return bytes;
}

}  // namespace im2fit::body
