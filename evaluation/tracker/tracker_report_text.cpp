// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "evaluation/tracker/tracker_report.h"
#include "report/text_table.h"

namespace im2fit::lab {
namespace {

std::string percent(double value, int decimals = 1) {
  return number(100 * value, decimals);
}

std::string row_name(const std::string& dimension, const std::string& value) {
  return value.empty() ? dimension : dimension + ": " + value;
}

std::string joint_table(const std::vector<JointRow>& rows, TrialCondition condition) {
  const std::string name = name_of(condition);
  TextTable table({"joints, " + name, "frames", "found %", "other %", "mean mm", "median", "p95", "in 10 cm %",
                   "first frame: mean", "p95", "in 10 cm %"});
  bool any = false;
  std::string dimension;
  for (const JointRow& row : rows) {
    if (row.condition != condition) continue;
    if (any && row.dimension != dimension) table.add({});
    dimension = row.dimension;
    any = true;
    const JointSummary& s = row.converged;
    table.add({row_name(row.dimension, row.value), std::to_string(s.frames), percent(share(s.found, s.frames)),
               percent(share(s.other, s.frames)), number(s.mean_mm, 1), number(s.median_mm, 1), number(s.p95_mm, 1),
               percent(s.within_100mm), number(row.cold.mean_mm, 1), number(row.cold.p95_mm, 1),
               percent(row.cold.within_100mm)});
  }
  return any ? table.text() + "\n" : "";
}

std::string mask_table(const std::vector<MaskRow>& rows) {
  if (rows.empty()) return "";
  TextTable table({"mask, IoU", "frames", "median", "p5", "worst", "mean", "first frame: median", "p5"});
  std::string dimension = rows.front().dimension;
  for (const MaskRow& row : rows) {
    if (row.dimension != dimension) table.add({});
    dimension = row.dimension;
    table.add({row_name(row.dimension, row.value), std::to_string(row.converged.frames),
               number(row.converged.median, 3), number(row.converged.p5, 3), number(row.converged.worst, 3),
               number(row.converged.mean, 3), number(row.cold.median, 3), number(row.cold.p5, 3)});
  }
  return table.text() + "\n";
}

// Stated chances down, classes across; how many joints stated so in the first column only.
std::string reliability_table(const std::vector<ReliabilityReport>& reports) {
  if (reports.empty()) return "";
  std::vector<std::string> header = {"confidence: within 5 cm, %", "joints", "stated %"};
  for (const ReliabilityReport& report : reports) header.push_back(report.of);
  TextTable table(header);
  for (std::size_t i = 0; i < Reliability::kBins; ++i) {
    const ReliabilityBin& all = reports.front().bins[i];
    if (all.joints == 0) continue;
    std::vector<std::string> cells = {fmt::format("stated about {} %", 10 * i), std::to_string(all.joints),
                                      percent(all.stated)};
    for (const ReliabilityReport& report : reports) cells.push_back(percent(report.bins[i].within));
    table.add(cells);
  }
  std::vector<std::string> cells = {"off by, on average", std::to_string(reports.front().joints), ""};
  for (const ReliabilityReport& report : reports) cells.push_back(percent(report.calibration_error));
  table.add(cells);
  return table.text() + "\n";
}

std::string people_text(const PeopleReport& p) {
  return fmt::format(
      "people       {} clips of two, {} frames: {} changes of person in {} clips, {} changes of id; a person's mask "
      "in "
      "{} % of the frames\n\n",
      p.clips, p.frames, p.switches, p.clips_switched, p.id_switches, percent(share(p.found, p.frames)));
}

std::string empty_text(const EmptyReport& e) {
  TextTable table({"empty rooms", "frames", "false users"});
  for (const auto& [kind, counts] : e.by_kind)
    table.add({kind, std::to_string(counts.first), std::to_string(counts.second)});
  table.add({"all", std::to_string(e.frames), std::to_string(e.false_users)});
  return table.text() + "\n";
}

// Codes as columns: what scenes of each kind raised, in percent of the scenes.
std::string guidance_table(const std::vector<GuidanceRow>& rows) {
  if (rows.empty()) return "";
  const auto was_raised = [&](std::size_t code) {
    for (const GuidanceRow& row : rows)
      if (row.raised[code] > 0) return true;
    return false;
  };
  std::vector<std::string> header = {"guidance, % of scenes", "scenes", "right", "silent", "unrelated", "none"};
  for (std::size_t i = 0; i < kGuidanceCount; ++i)
    if (was_raised(i)) header.emplace_back(kGuidanceNames[i]);
  TextTable table(header);
  for (const GuidanceRow& row : rows) {
    const auto cell = [&](std::uint64_t count) { return count > 0 ? percent(share(count, row.scenes), 0) : "."; };
    std::vector<std::string> cells = {
        row.kind,         std::to_string(row.scenes), percent(share(row.right, row.scenes), 0),
        cell(row.silent), cell(row.unrelated),        cell(row.nothing)};
    for (std::size_t i = 0; i < kGuidanceCount; ++i)
      if (was_raised(i)) cells.push_back(cell(row.raised[i]));
    table.add(cells);
  }
  return table.text() + "\n";
}

std::string target_table(const std::vector<Target>& targets) {
  TextTable table({"target", "figure", "limit", ""});
  for (const Target& target : targets)
    table.add({target.name, number(target.figure, target.decimals),
               (target.at_most ? "<= " : ">= ") + number(target.limit, target.decimals),
               target.met() ? "met" : "MISSED"});
  return table.text();
}

}  // namespace

std::string text_of(const TrackerReport& report) {
  std::string text =
      fmt::format("synthetic, held-out people, seed {}; rows: after five frames, right: first frame\n{}\n\n",
                  report.seed, report.model);
  text += joint_table(report.joints, TrialCondition::full) + joint_table(report.joints, TrialCondition::bare) +
          joint_table(report.joints, TrialCondition::wide);
  text += mask_table(report.masks) + reliability_table(report.reliability);
  if (report.people) text += people_text(*report.people);
  if (report.empty) text += empty_text(*report.empty);
  return text + guidance_table(report.guidance) + target_table(report.targets);
}

}  // namespace im2fit::lab
