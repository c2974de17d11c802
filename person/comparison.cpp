// SPDX-License-Identifier: Apache-2.0
#include "person/comparison.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "formats/json_file.h"
#include "person/person_measurement.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// Millimetres (weight: kg), in the order of core/measurement.h: docs/compare.md says how they were measured.
struct RepeatErrors {
  std::string_view views;
  std::array<double, kMeasurementCount> tem;
};
constexpr RepeatErrors kRepeatErrors[] = {
    {"front", {4.0, 3.9, 2.8, 3.7, 7.2, 8.4, 8.1, 11.6, 14.6, 2.9, 1.8}},
    {"around", {4.1, 4.6, 2.7, 2.9, 7.4, 6.7, 5.9, 5.4, 8.2, 2.9, 0.6}},
};

// People are taller in the morning by up to so much (docs/compare.md).
constexpr double kWithinADayMm = 20;

std::string text_at(const Json& root, const char* pointer) {
  const Json::json_pointer at(pointer);
  return root.contains(at) && root[at].is_string() ? root[at].get<std::string>() : std::string();
}

float half_of(const index::IntervalEstimate& e) {
  return 0.5F * (e.high - e.low);
}

Result<index::IntervalEstimate> estimate_of(const Json& root, std::string_view id, const std::string& path) {
  const std::string at = "/measurements/" + std::string(id);
  const auto number = [&](const std::string& field) {
    const Json::json_pointer place(at + field);
    return root.contains(place) && root[place].is_number() ? root[place].get<float>() : kNone;
  };
  const index::IntervalEstimate e = {number("/value"), number("/interval/0"), number("/interval/1")};
  if (!std::isfinite(e.value)) return index::IntervalEstimate{kNone, kNone, kNone};
  if (!(e.low <= e.value && e.value <= e.high))
    return Error{ErrorCode::corrupt, path + ": measurements/" + std::string(id) +
                                         " has no interval about its value; expected [low, high]"};
  return e;
}

void add_if(std::vector<std::string>& reasons, bool differs, const std::string& reason) {
  if (differs) reasons.push_back(reason);
}

std::string or_none(const std::string& text) {
  return text.empty() ? "none" : text;
}

std::vector<std::string> reasons_to_widen(const Capture& a, const Capture& b) {
  std::vector<std::string> all;
  add_if(all, a.views != b.views, "views: " + or_none(a.views) + " and " + or_none(b.views));
  add_if(all, a.views == b.views && repeat_error(Measurement::stature, a.views) == 0,
         "repeatability is not known for the views " + or_none(a.views));
  add_if(all, a.index.empty() || b.index.empty(), "the results do not both name their models");
  add_if(all, !a.index.empty() && !b.index.empty() && a.index != b.index,
         "models: index " + a.index + " and " + b.index);
  add_if(all, a.program != b.program, "program: " + or_none(a.program) + " and " + or_none(b.program));
  add_if(all, a.answered_as != b.answered_as,
         "clothing: " + or_none(a.answered_as) + " and " + or_none(b.answered_as));
  // What is answered as bare is of the surface seen, which may be cloth.
  add_if(all, a.answered_as == b.answered_as && (a.answered_as != "bare" || a.looks_dressed || b.looks_dressed),
         "repeatability is not known for dressed people");
  add_if(all, a.site != b.site, "site calibration: " + or_none(a.site) + " and " + or_none(b.site));
  add_if(all, a.known != b.known, "the reported facts differ");
  return all;
}

}  // namespace

double repeat_error(Measurement measurement, const std::string& views) {
  for (const RepeatErrors& one : kRepeatErrors)
    if (one.views == views) return one.tem[measurement_index(measurement)];
  return 0;
}

Result<Capture> read_capture(const std::string& path) {
  std::error_code code;
  Capture capture;
  capture.path = std::filesystem::is_directory(path, code) ? path + "/result.json" : path;
  const auto json = read_json<Json>(capture.path);
  if (!json) return json.error();
  const Json& root = *json;
  if (text_at(root, "/schema") != kResultSchema)
    return Error{ErrorCode::unsupported,
                 capture.path + ": expected a result.json, schema " + std::string(kResultSchema)};
  if (!root.contains("measurements") || !root["measurements"].is_object() || root["measurements"].empty())
    return Error{ErrorCode::invalid_argument, capture.path + ": nobody was measured"};
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    auto estimate = estimate_of(root, kMeasurementTable[i].id, capture.path);
    if (!estimate) return estimate.error();
    capture.measurements[i] = *estimate;
  }
  if (!std::isfinite(capture.measurements[measurement_index(Measurement::stature)].value))
    return Error{ErrorCode::corrupt, capture.path + ": measurements/stature is missing"};
  capture.views = text_at(root, "/views");
  capture.answered_as = text_at(root, "/clothing/answered_as");
  const Json::json_pointer dressed("/clothing/probability");
  capture.looks_dressed = root.contains(dressed) && root[dressed].is_number() && root[dressed].get<float>() >= 0.5F;
  capture.program = text_at(root, "/made_by/im2fit");
  capture.index = text_at(root, "/made_by/index");
  capture.site = text_at(root, "/calibration_site/crc32c");
  const Json::json_pointer given("/known/given");
  if (root.contains(given) && root.contains("/known/used"_json_pointer) && !root["known"]["used"].empty())
    capture.known = root[given].dump();
  return capture;
}

Comparison compare(const Capture& before, const Capture& after) {
  Comparison out;
  out.wider = reasons_to_widen(before, after);
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const auto measurement = static_cast<Measurement>(i);
    const index::IntervalEstimate &a = before.measurements[i], &b = after.measurements[i];
    const double repeated =
        before.views == after.views ? std::sqrt(2.0) * repeat_error(measurement, before.views) : 0;
    const auto half_a = static_cast<double>(half_of(a)), half_b = static_cast<double>(half_of(b));
    const double independent = std::hypot(half_a, half_b) / kComparisonSds;
    const double sd = out.wider.empty() ? repeated : std::max(repeated, independent);
    out.changes[i] = {measurement, a.value, b.value, b.value - a.value, static_cast<float>(kComparisonSds * sd)};
    if (measurement == Measurement::stature)
      out.two_people = std::fabs(static_cast<double>(b.value) - static_cast<double>(a.value)) >
                       std::hypot(half_a, half_b) + kWithinADayMm;
  }
  return out;
}

}  // namespace im2fit
