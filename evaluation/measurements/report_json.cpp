// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "evaluation/measurements/report.h"

namespace im2fit::lab {
namespace {

using Json = nlohmann::ordered_json;

Json statistics_json(const ErrorStatistics& s) {
  if (s.count == 0) return nullptr;
  return {{"count", s.count}, {"bias", s.bias}, {"mae", s.mae}, {"sd", s.sd}, {"p95", s.p95}, {"max", s.max}};
}

Json levels_json(const MeasurementReport& r) {
  Json levels = Json::array();
  for (std::size_t i = 0; i < kLevels.size(); ++i)
    levels.push_back({{"nominal", kLevels[i].share}, {"covered", r.covered[i]}});
  return levels;
}

Json repeatability_json(const Repeatability& r) {
  return {{"pairs", r.pairs}, {"tem", r.tem}, {"tem_percent", r.percent}, {"reliability", r.reliability}};
}

// No true value is known: every figure that needs one is null.
Json unjudged(Json entry, const MeasurementReport& r) {
  for (const char* figure : {"coverage_95", "interval_width", "interval_width_median", "calibration", "agreement"})
    entry[figure] = nullptr;
  if (r.repeatability.pairs > 0) entry["repeatability"] = repeatability_json(r.repeatability);
  for (const Estimator estimator : {Estimator::paper, Estimator::raw, Estimator::nearest})
    entry[std::string(kEstimators[static_cast<std::size_t>(estimator)].json)] = nullptr;
  return entry;
}

Json measurement_json(const MeasurementReport& r, std::size_t m) {
  const auto id = static_cast<Measurement>(m);
  const ErrorStatistics& ours = r.of(Estimator::ours);
  Json entry;
  entry["unit"] = kMeasurementTable[m].unit;
  entry["ours"] = statistics_json(ours);
  if (!r.judged()) return unjudged(std::move(entry), r);
  entry["coverage_95"] = r.coverage();
  entry["interval_width"] = r.interval_width;
  entry["interval_width_median"] = r.interval_width_median;
  entry["calibration"] = levels_json(r);
  if (iso_20685_limit_mm(id) > 0)
    entry["iso_20685"] = {{"limit_mm", iso_20685_limit_mm(id)},
                          {"mean_low", ours.mean_low},
                          {"mean_high", ours.mean_high},
                          {"inside", within_iso_20685(ours, id)}};
  entry["agreement"] = {{"bias", r.agreement.bias},
                        {"limit_low", r.agreement.low},
                        {"limit_high", r.agreement.high},
                        {"slope", r.agreement.slope}};
  if (r.repeatability.pairs > 0) entry["repeatability"] = repeatability_json(r.repeatability);
  for (const Estimator estimator : {Estimator::paper, Estimator::raw, Estimator::nearest})
    entry[std::string(kEstimators[static_cast<std::size_t>(estimator)].json)] = statistics_json(r.of(estimator));
  return entry;
}

Json with_json(const MeasuredWith& with) {
  return {{"dataset_version", with.dataset_version ? Json(*with.dataset_version) : Json()},
          {"index_format", with.index_format},
          {"index_models", with.index_models},
          {"seed", with.seed},
          {"commit", with.commit}};
}

Json groups_json(const Report& report) {
  Json groups = Json::array();
  for (const GroupReport& group : report.groups) {
    Json entry = {{"name", group.name},
                  {"people", group.people},
                  {"bmi_low", group.mass_index_low},
                  {"bmi_high", group.mass_index_high}};
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const GroupReport::Row& row = group.rows[m];
      Json& of = entry["measurements"][std::string(kMeasurementTable[m].id)];
      of = row.people > 0 ? Json{{"bias", row.bias}, {"mae", row.mae}, {"coverage_95", row.coverage}} : Json();
    }
    groups.push_back(std::move(entry));
  }
  return groups;
}

}  // namespace

Json json_value_of(const Report& report) {
  Json json;
  json["schema"] = "im2fit.evaluation/1";
  json["label"] = "synthetic";
  if (!report.family.empty()) json["family"] = report.family;
  json["condition"] = report.condition;
  if (!report.what.empty()) json["what"] = report.what;
  json["measured_with"] = with_json(report.with);
  json["subjects"] = report.subjects;
  json["measured"] = report.measured;
  json["lifted_arms"] = report.lifted_arms;
  for (std::size_t fact = 0; fact < kKnownFactCount; ++fact)
    if (report.facts_used[fact] + report.facts_doubted[fact] > 0)
      json["known"][std::string(kKnownFactNames[fact])] = {{"used", report.facts_used[fact]},
                                                           {"doubted", report.facts_doubted[fact]}};
  json["not_measured_because"] = Json::object();
  for (std::size_t g = 0; g < kGuidanceCount; ++g)
    if (report.not_measured_because[g] > 0)
      json["not_measured_because"][std::string(kGuidanceNames[g])] = report.not_measured_because[g];
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    json["measurements"][std::string(kMeasurementTable[m].id)] = measurement_json(report.measurements[m], m);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    Json& slope = json["measurements"][std::string(kMeasurementTable[m].id)]["error_by_bmi"];
    if (report.measurements[m].judged())
      slope = {{"slope", report.slopes[m].slope}, {"standard_error", report.slopes[m].standard_error}};
  }
  json["groups"] = groups_json(report);
  json["sex_accuracy"] = report.sex_accuracy;
  if (report.clothing_estimated > 0)
    json["clothing"] = {{"people", report.clothing_estimated},
                        {"right", report.clothing_right},
                        {"ease_mm", report.clothing_ease_mm}};
  if (report.has_raw()) json["raw_nearest_sex_accuracy"] = report.raw_sex_accuracy;
  json["age"] = {{"mean_error_years", report.age_error_years},
                 {"coverage", report.age_coverage},
                 {"group_right", report.age_band_accuracy},
                 {"group_right_promised", report.age_band_expected}};
  json["size"] = {{"outright", report.size_accuracy}, {"among_two", report.size_top_two}};
  json["joints"] = {{"mean_error_mm", report.joint_error_mm}, {"within_100_mm", report.joints_within_100mm}};
  return json;
}

std::string json_of(const Report& report) {
  return json_value_of(report).dump(1) + "\n";
}

}  // namespace im2fit::lab
