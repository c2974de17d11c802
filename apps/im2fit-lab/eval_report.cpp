// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/eval_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/common/text_table.h"
#include "engine/size_chart.h"

namespace im2fit::apps {
namespace {

using Json = nlohmann::ordered_json;

MeasurementReport measurement_report(const std::vector<const Outcome*>& measured, std::size_t m) {
  std::vector<double> ours;
  std::vector<double> paper;
  std::vector<double> raw;
  std::vector<double> nearest;
  int covered = 0;
  for (const Outcome* o : measured) {
    const double truth = o->truth[m];
    const index::Estimate& estimate = o->answer.measurements[m];
    ours.push_back(estimate.value - truth);
    paper.push_back(o->paper[m] - truth);
    nearest.push_back(o->answer.nearest_values[m] - truth);
    if (o->has_raw) raw.push_back(o->raw.values[m] - truth);
    if (truth >= estimate.low && truth <= estimate.high) ++covered;
  }
  MeasurementReport report{error_statistics(ours), error_statistics(paper), error_statistics(raw),
                           error_statistics(nearest), 0};
  if (!measured.empty()) report.coverage = covered / static_cast<double>(measured.size());
  return report;
}

double share(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

template <class Predicate>
double share_of(const std::vector<const Outcome*>& outcomes, const Predicate& holds) {
  return share(static_cast<std::size_t>(std::count_if(outcomes.begin(), outcomes.end(), holds)), outcomes.size());
}

void add_joints(const std::vector<Outcome>& outcomes, Report& report) {
  double sum_mm = 0;
  std::size_t count = 0;
  std::size_t within = 0;
  for (const Outcome& o : outcomes) {
    sum_mm += o.joint_error_sum_mm;
    count += static_cast<std::size_t>(o.joint_count);
    within += static_cast<std::size_t>(o.joints_within_100mm);
  }
  report.joint_error_mm = count > 0 ? sum_mm / static_cast<double>(count) : 0;
  report.joints_within_100mm = share(within, count);
}

Json statistics_json(const ErrorStatistics& s) {
  if (s.count == 0) return nullptr;
  return {{"count", s.count}, {"bias", s.bias}, {"mae", s.mae}, {"sd", s.sd}, {"p95", s.p95}, {"max", s.max}};
}

std::string mae_cell(const ErrorStatistics& s) {
  return s.count > 0 ? number(s.mae, 1) : "-";
}

std::string iso_cell(const ErrorStatistics& s, Measurement id) {
  if (iso_20685_limit_mm(id) <= 0) return "-";
  return fmt::format("{:.1f}..{:.1f} {} {:.0f}", s.mean_low, s.mean_high, within_iso_20685(s, id) ? "in" : "over",
                     iso_20685_limit_mm(id));
}

std::string refusals(const Report& report) {
  std::string text;
  for (std::size_t g = 0; g < kGuidanceCount; ++g)
    if (report.not_measured_because[g] > 0)
      text += fmt::format(" {} {}", kGuidanceNames[g], report.not_measured_because[g]);
  return text;
}

// The label of a chest girth in the chart of the person's own sex; what lies outside is named as the answer names it.
std::string true_size(double chest_mm, bool woman) {
  const SizeChart& chart = woman ? builtin_size_system().women : builtin_size_system().men;
  for (const SizeRow& row : chart.rows)
    if (chest_mm >= row.low_mm && chest_mm < row.high_mm) return row.size;
  return chest_mm < chart.rows.front().low_mm ? "<" + chart.rows.front().size : ">" + chart.rows.back().size;
}

// 0: the true size is the most probable, 1: the next, and so on.
std::size_t size_rank(const Outcome& o) {
  constexpr std::size_t kChest = measurement_index(Measurement::chest_girth);
  auto answer = size_probabilities(builtin_size_system(), o.answer.measurements[kChest], o.answer.female);
  std::stable_sort(answer.entries.begin(), answer.entries.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  const std::string truth = true_size(o.truth[kChest], o.woman);
  std::size_t rank = 0;
  while (rank < answer.entries.size() && answer.entries[rank].size != truth) ++rank;
  return rank;
}

}  // namespace

Report report_of(const std::vector<Outcome>& outcomes, const std::string& condition) {
  Report report;
  report.condition = condition;
  report.subjects = static_cast<int>(outcomes.size());
  std::vector<const Outcome*> measured;
  std::vector<const Outcome*> with_raw;
  for (const Outcome& o : outcomes) {
    if (o.measured) measured.push_back(&o);
    if (o.measured && o.has_raw) with_raw.push_back(&o);
    for (std::size_t g = 0; g < kGuidanceCount; ++g)
      if (!o.measured && (o.guidance_seen >> g & 1U) != 0) ++report.not_measured_because[g];
  }
  report.measured = static_cast<int>(measured.size());
  for (std::size_t m = 0; m < kMeasurementCount; ++m) report.measurements[m] = measurement_report(measured, m);
  report.sex_accuracy = share_of(measured, [](const Outcome* o) { return (o->answer.female > 0.5F) == o->woman; });
  report.raw_sex_accuracy = share_of(with_raw, [](const Outcome* o) { return o->raw.woman == o->woman; });
  report.size_accuracy = share_of(measured, [](const Outcome* o) { return size_rank(*o) == 0; });
  report.size_top_two = share_of(measured, [](const Outcome* o) { return size_rank(*o) <= 1; });
  add_joints(outcomes, report);
  return report;
}

std::string text_of(const Report& report) {
  TextTable table({"synthetic, " + report.condition, "bias", "MAE", "SD", "p95", "max", "ISO 20685 mean",
                   "in 95 % int.", "paper MAE", "raw NN MAE", "nearest MAE"});
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const MeasurementReport& r = report.measurements[m];
    const auto& info = kMeasurementTable[m];
    table.add({fmt::format("{} {}", info.id, info.unit), number(r.ours.bias, 1), number(r.ours.mae, 1),
               number(r.ours.sd, 1), number(r.ours.p95, 1), number(r.ours.max, 1),
               iso_cell(r.ours, static_cast<Measurement>(m)), number(100 * r.coverage, 1), mae_cell(r.paper),
               mae_cell(r.raw), mae_cell(r.nearest)});
  }
  const bool has_raw = report.measurements[0].raw.count > 0;
  std::string text = table.text();
  text +=
      fmt::format("\nmeasured     {} of {} held-out synthetic people ({:.1f} %)\n", report.measured, report.subjects,
                  100 * share(static_cast<std::size_t>(report.measured), static_cast<std::size_t>(report.subjects)));
  if (report.measured < report.subjects) text += "not, having been told" + refusals(report) + "\n";
  text += fmt::format("sex          {:.1f} % right{}\n", 100 * report.sex_accuracy,
                      has_raw ? fmt::format(" (raw nearest neighbour {:.1f} %)", 100 * report.raw_sex_accuracy) : "");
  text += fmt::format("letter size  {:.1f} % outright, {:.1f} % among the two most probable\n",
                      100 * report.size_accuracy, 100 * report.size_top_two);
  text += fmt::format("joints       {:.1f} mm mean error, {:.1f} % within 100 mm\n", report.joint_error_mm,
                      100 * report.joints_within_100mm);
  return text;
}

std::string json_of(const Report& report) {
  Json json;
  json["schema"] = "im2fit.evaluation/1";
  json["label"] = "synthetic";
  json["condition"] = report.condition;
  json["subjects"] = report.subjects;
  json["measured"] = report.measured;
  json["not_measured_because"] = Json::object();
  for (std::size_t g = 0; g < kGuidanceCount; ++g)
    if (report.not_measured_because[g] > 0)
      json["not_measured_because"][std::string(kGuidanceNames[g])] = report.not_measured_because[g];
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const MeasurementReport& r = report.measurements[m];
    const auto id = static_cast<Measurement>(m);
    Json entry;
    entry["unit"] = kMeasurementTable[m].unit;
    entry["ours"] = statistics_json(r.ours);
    entry["coverage_95"] = r.coverage;
    if (iso_20685_limit_mm(id) > 0)
      entry["iso_20685"] = {{"limit_mm", iso_20685_limit_mm(id)},
                            {"mean_low", r.ours.mean_low},
                            {"mean_high", r.ours.mean_high},
                            {"inside", within_iso_20685(r.ours, id)}};
    entry["paper"] = statistics_json(r.paper);
    entry["raw_nearest"] = statistics_json(r.raw);
    entry["projected_nearest"] = statistics_json(r.nearest);
    json["measurements"][std::string(kMeasurementTable[m].id)] = entry;
  }
  json["sex_accuracy"] = report.sex_accuracy;
  if (report.measurements[0].raw.count > 0) json["raw_nearest_sex_accuracy"] = report.raw_sex_accuracy;
  json["size"] = {{"outright", report.size_accuracy}, {"among_two", report.size_top_two}};
  json["joints"] = {{"mean_error_mm", report.joint_error_mm}, {"within_100_mm", report.joints_within_100mm}};
  return json.dump(1) + "\n";
}

}  // namespace im2fit::apps
