// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/tracker/tracker_report.h"

namespace im2fit::lab {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN: a value that was not measured is null. Rounded to 1 / `steps`.
Json rounded(double value, double steps = 1e4) {
  return std::isfinite(value) ? Json(std::round(value * steps) / steps) : Json(nullptr);
}

Json summary_json(const JointSummary& s) {
  return {{"frames", s.frames},
          {"found", s.found},
          {"other", s.other},
          {"joints", s.joints},
          {"mean_mm", rounded(s.mean_mm)},
          {"median_mm", rounded(s.median_mm)},
          {"p95_mm", rounded(s.p95_mm)},
          {"within_50mm", rounded(s.within_50mm, 1e6)},
          {"within_100mm", rounded(s.within_100mm, 1e6)}};
}

Json mask_json(const MaskSummary& s) {
  return {{"frames", s.frames},
          {"median", rounded(s.median, 1e6)},
          {"p5", rounded(s.p5, 1e6)},
          {"worst", rounded(s.worst, 1e6)},
          {"mean", rounded(s.mean, 1e6)}};
}

Json joints_json(const std::vector<JointRow>& rows) {
  Json out = Json::array();
  for (const JointRow& row : rows)
    out.push_back({{"condition", name_of(row.condition)},
                   {"class", row.dimension},
                   {"value", row.value},
                   {"converged", summary_json(row.converged)},
                   {"first_frame", summary_json(row.cold)}});
  return out;
}

Json masks_json(const std::vector<MaskRow>& rows) {
  Json out = Json::array();
  for (const MaskRow& row : rows)
    out.push_back({{"class", row.dimension},
                   {"value", row.value},
                   {"converged", mask_json(row.converged)},
                   {"first_frame", mask_json(row.cold)}});
  return out;
}

Json reliability_json(const std::vector<ReliabilityReport>& reports) {
  Json out = Json::array();
  for (const ReliabilityReport& report : reports) {
    Json bins = Json::array();
    for (const ReliabilityBin& bin : report.bins)
      bins.push_back(
          {{"joints", bin.joints}, {"stated", rounded(bin.stated, 1e6)}, {"within_50mm", rounded(bin.within, 1e6)}});
    out.push_back({{"of", report.of},
                   {"joints", report.joints},
                   {"calibration_error", rounded(report.calibration_error, 1e6)},
                   {"bins", bins}});
  }
  return out;
}

Json people_json(const PeopleReport& p) {
  return {{"clips", p.clips},
          {"frames", p.frames},
          {"found", p.found},
          {"switches", p.switches},
          {"clips_switched", p.clips_switched},
          {"id_switches", p.id_switches}};
}

Json empty_json(const EmptyReport& e) {
  Json kinds = Json::object();
  for (const auto& [kind, counts] : e.by_kind)
    kinds[kind] = {{"frames", counts.first}, {"false_users", counts.second}};
  return {{"rooms", e.rooms}, {"frames", e.frames}, {"false_users", e.false_users}, {"by_kind", kinds}};
}

Json guidance_json(const std::vector<GuidanceRow>& rows) {
  Json out = Json::array();
  for (const GuidanceRow& row : rows) {
    Json raised = Json::object();
    for (std::size_t i = 0; i < kGuidanceCount; ++i)
      if (row.raised[i] > 0) raised[std::string(kGuidanceNames[i])] = row.raised[i];
    out.push_back({{"kind", row.kind},
                   {"scenes", row.scenes},
                   {"right", row.right},
                   {"silent", row.silent},
                   {"unrelated", row.unrelated},
                   {"nothing", row.nothing},
                   {"raised", raised}});
  }
  return out;
}

Json targets_json(const std::vector<Target>& targets) {
  Json out = Json::array();
  for (const Target& target : targets)
    out.push_back({{"name", target.name},
                   {"figure", rounded(target.figure)},
                   {target.at_most ? "at_most" : "at_least", target.limit},
                   {"met", target.met()}});
  return out;
}

}  // namespace

std::string json_of(const TrackerReport& report) {
  Json json = {{"schema", "im2fit.tracker-evaluation/1"},
               {"data", "synthetic"},
               {"model", report.model},
               {"seed", report.seed},
               {"subjects", report.subjects}};
  if (!report.joints.empty()) json["joints"] = joints_json(report.joints);
  if (!report.masks.empty()) json["segmentation"] = masks_json(report.masks);
  if (!report.reliability.empty()) json["confidence"] = reliability_json(report.reliability);
  if (report.people) json["people"] = people_json(*report.people);
  if (report.empty) json["empty"] = empty_json(*report.empty);
  if (!report.guidance.empty()) json["guidance"] = guidance_json(report.guidance);
  json["targets"] = targets_json(report.targets);
  return json.dump(2) + "\n";
}

}  // namespace im2fit::lab
