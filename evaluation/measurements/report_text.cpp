// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "evaluation/measurements/report.h"
#include "report/text_table.h"

namespace im2fit::lab {
namespace {

std::string mae_cell(const ErrorStatistics& s) {
  return s.count > 0 ? number(s.mae, 1) : "-";
}

std::string iso_cell(const ErrorStatistics& s, Measurement id) {
  if (iso_20685_limit_mm(id) <= 0 || s.count == 0) return "-";
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

std::string table_of(const Report& report) {
  std::vector<std::string> header = {"synthetic, " + title_of(report),
                                     "bias",
                                     "MAE",
                                     "SD",
                                     "p95",
                                     "max",
                                     "ISO 20685 mean",
                                     "in 95 % int.",
                                     "paper MAE",
                                     "raw NN MAE",
                                     "nearest MAE"};
  if (report.has_repeats()) header.emplace_back("TEM");
  TextTable table(header);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const MeasurementReport& r = report.measurements[m];
    const ErrorStatistics& ours = r.of(Estimator::ours);
    const auto& info = kMeasurementTable[m];
    const auto judged = [&](double value) { return r.judged() ? number(value, 1) : "-"; };
    std::vector<std::string> row = {fmt::format("{} {}", info.id, info.unit),
                                    judged(ours.bias),
                                    judged(ours.mae),
                                    judged(ours.sd),
                                    judged(ours.p95),
                                    judged(ours.max),
                                    iso_cell(ours, static_cast<Measurement>(m)),
                                    judged(100 * r.coverage()),
                                    mae_cell(r.of(Estimator::paper)),
                                    mae_cell(r.of(Estimator::raw)),
                                    mae_cell(r.of(Estimator::nearest))};
    if (report.has_repeats()) row.push_back(number(r.repeatability.tem, 1));
    table.add(row);
  }
  return table.text();
}

constexpr std::array kGrouped = {Measurement::stature,     Measurement::neck_girth, Measurement::chest_girth,
                                 Measurement::waist_girth, Measurement::hip_girth,  Measurement::weight};

// Bias, mean absolute error and share of truths inside the 95 % interval, by sex and body mass index.
std::string groups_table(const Report& report) {
  std::vector<std::string> header = {"bias / MAE / in 95 % int.", "people"};
  for (const Measurement m : kGrouped)
    header.push_back(fmt::format("{} {}", kMeasurementTable[measurement_index(m)].id,
                                 kMeasurementTable[measurement_index(m)].unit));
  TextTable table(header);
  for (const GroupReport& group : report.groups) {
    std::vector<std::string> row = {group.name, fmt::format("{}", group.people)};
    for (const Measurement m : kGrouped) {
      const GroupReport::Row& r = group.rows[measurement_index(m)];
      row.push_back(r.people > 0 ? fmt::format("{:+.1f} / {:.1f} / {:.0f}", r.bias, r.mae, 100 * r.coverage) : "-");
    }
    table.add(row);
  }
  std::vector<std::string> slopes = {"error a kg/m2 of BMI", fmt::format("{}", report.measured)};
  for (const Measurement m : kGrouped) {
    const IndexSlope& s = report.slopes[measurement_index(m)];
    slopes.push_back(fmt::format("{:+.2f} +- {:.2f}", s.slope, s.standard_error));
  }
  table.add(slopes);
  return table.text();
}

}  // namespace

std::string text_of(const Report& report) {
  std::string text = report.measured > 0 ? table_of(report) : "synthetic, " + title_of(report) + "\n";
  const double measured = report.subjects > 0 ? 100.0 * report.measured / report.subjects : 0;
  text += fmt::format("\nmeasured     {} of {} held-out synthetic people ({:.1f} %)\n", report.measured,
                      report.subjects, measured);
  for (std::size_t fact = 0; fact < kKnownFactCount; ++fact)
    if (const int used = report.facts_used[fact], doubted = report.facts_doubted[fact]; used + doubted > 0)
      text +=
          fmt::format("             known {}: used for {}, doubted for {}\n", kKnownFactNames[fact], used, doubted);
  if (report.lifted_arms > 0)
    text += fmt::format("             {} of them after lifting their arms at ARMS_CLOSE\n", report.lifted_arms);
  if (report.measured < report.subjects) text += "not measured; guidance:" + refusals(report) + "\n";
  if (report.measured == 0) return text;
  text += fmt::format(
      "sex          {:.1f} % right{}\n", 100 * report.sex_accuracy,
      report.has_raw() ? fmt::format(" (raw nearest neighbour {:.1f} %)", 100 * report.raw_sex_accuracy) : "");
  if (report.clothing_estimated > 0)
    text += fmt::format("clothing     bare or dressed: {:.1f} % right by the frames alone, expected ease {:.1f} mm\n",
                        100 * report.clothing_right, report.clothing_ease_mm);
  text += fmt::format(
      "age          {:.1f} years mean error, {:.1f} % in the 95 % interval; group {:.1f} % right, {:.1f} % "
      "promised\n",
      report.age_error_years, 100 * report.age_coverage, 100 * report.age_band_accuracy,
      100 * report.age_band_expected);
  text += fmt::format("letter size  {:.1f} % outright, {:.1f} % among the two most probable\n",
                      100 * report.size_accuracy, 100 * report.size_top_two);
  text += fmt::format("joints       {:.1f} mm mean error, {:.1f} % within 100 mm\n", report.joint_error_mm,
                      100 * report.joints_within_100mm);
  return text + "\n" + groups_table(report);
}

std::string text_of(const std::vector<ConditionRun>& runs) {
  std::vector<std::string> header = {"MAE, synthetic"};
  for (const ConditionRun& run : runs) header.push_back(title_of(run.report));
  TextTable table(header);
  const auto row = [&](const std::string& name, const auto& cell) {
    std::vector<std::string> cells = {name};
    for (const ConditionRun& run : runs) cells.push_back(cell(run.report));
    table.add(cells);
  };
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    row(fmt::format("{} {}", kMeasurementTable[m].id, kMeasurementTable[m].unit),
        [&](const Report& r) { return mae_cell(r.measurements[m].of(Estimator::ours)); });
  row("in 95 % interval", [](const Report& r) { return number(100 * mean_coverage(r), 1); });
  row("sex right %", [](const Report& r) { return number(100 * r.sex_accuracy, 1); });
  row("age years", [](const Report& r) { return number(r.age_error_years, 1); });
  row("size outright %", [](const Report& r) { return number(100 * r.size_accuracy, 1); });
  row("joints mm", [](const Report& r) { return number(r.joint_error_mm, 1); });
  row("measured", [](const Report& r) { return fmt::format("{}/{}", r.measured, r.subjects); });
  return table.text();
}

}  // namespace im2fit::lab
