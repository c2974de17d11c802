// SPDX-License-Identifier: Apache-2.0
#include "report/full_result.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/file.h"
#include "formats/json_file.h"
#include "person/body_figures.h"
#include "person/data_files.h"

namespace im2fit {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTenths = 10, kHundredths = 100, kThousandths = 1000;

Json rounded(float value, double steps) {
  if (!std::isfinite(value)) return nullptr;
  return std::floor(static_cast<double>(value) * steps + 0.5) / steps;
}

Json estimate_json(const index::IntervalEstimate& e, const char* unit, double steps) {
  return {{"value", rounded(e.value, steps)},
          {"unit", unit},
          {"interval", Json::array({rounded(e.low, steps), rounded(e.high, steps)})}};
}

Json fat_json(const NavyFat& fat) {
  Json json = {{"method", "U.S. Navy"},
               {"source", "Hodgdon and Beckett 1984, Naval Health Research Center, report " +
                              std::string(fat.woman ? "84-29" : "84-11")},
               {"sex", fat.woman ? "woman" : "man"},
               {"girths", fat.woman ? Json{"natural_waist_girth", "hip_girth", "neck_girth"}
                                    : Json{"navel_girth", "neck_girth"}}};
  json.update(estimate_json(fat.percent, "%", kTenths));
  json["standard_error"] = rounded(fat.standard_error, kHundredths);
  return json;
}

Json figures_json(const BodyFigures& figures) {
  Json json = {{"volume", estimate_json(figures.volume_l, "l", kTenths)},
               {"surface_area", estimate_json(figures.surface_area_m2, "m2", kThousandths)},
               {"waist_to_hip", estimate_json(figures.waist_to_hip, "1", kThousandths)},
               {"waist_to_height", estimate_json(figures.waist_to_height, "1", kThousandths)},
               {"body_mass_index", estimate_json(figures.body_mass_index, "kg/m2", kTenths)}};
  if (figures.fat) json["body_fat"] = fat_json(*figures.fat);
  return json;
}

}  // namespace

std::uint32_t index_digest(const std::string& path) {
  // The checksum of a container's table, which has those of its sections (core/container.h).
  constexpr std::size_t kDigestAt = 24;
  std::vector<std::byte> bytes;
  if (is_model_pack(path)) {
    auto packed = model_bytes(path, kPackedIndex);
    if (packed) bytes = std::move(*packed);
  } else if (!read_file_into(path, SIZE_MAX, kDigestAt + sizeof(std::uint32_t), bytes)) {
    return 0;
  }
  std::uint32_t digest = 0;
  if (bytes.size() >= kDigestAt + sizeof digest) std::memcpy(&digest, bytes.data() + kDigestAt, sizeof digest);
  return digest;
}

std::string full_result_json(const PersonMeasurement& person, const MeasuringData& data,
                             const std::optional<ResultTiming>& timing) {
  std::string text = result_json(person, timing);
  if (!person.result.measured) return text;
  Json json;
  // Not read: the results of unknown models are not alike.
  const std::uint32_t digest = index_digest(data.files.index);
  json["made_by"] = {{"im2fit", IM2FIT_VERSION}, {"index", digest == 0 ? "" : fmt::format("{:08x}", digest)}};
  if (person.body && data.body_model) {
    json["figures"] = figures_json(body_figures(person.result.answer, *person.body, *data.body_model, person.tape,
                                                person.tape_values, person.tape_intervals));
    if (const auto tilt = shoulder_tilt_deg(person.result.measured_joints, person.result.floor))
      json["figures"]["shoulder_tilt"] = estimate_json(*tilt, "deg", kTenths);
  }
  // After the last field of the object, in whose way it is written: no need to read it.
  text.resize(text.rfind("\n}"));
  return text + "," + json_text(json, 2).substr(1) + "\n";
}

}  // namespace im2fit
