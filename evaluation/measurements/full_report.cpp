// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/full_report.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "evaluation/measurements/paper_says.h"
#include "report/page_style.h"

namespace im2fit::lab {
namespace {

std::string card(const std::string& figure, const std::string& what, const std::string& beside) {
  return fmt::format("<div class=\"card\"><span>{}</span><b>{}</b><span>{}</span></div>\n", what, figure, beside);
}

double mean_girth_mae(const Report& r) {
  double sum = 0;
  int count = 0;
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    if (kMeasurementTable[m].id.ends_with("girth") && r.measurements[m].judged()) {
      sum += r.measurements[m].of(Estimator::ours).mae;
      ++count;
    }
  return sum / count;
}

std::string cards_of(const Report& r) {
  const auto mae = [&](Measurement m) { return r.measurements[measurement_index(m)].of(Estimator::ours).mae; };
  return "<div class=\"cards\">\n" +
         card(fmt::format("{:.1f} mm", mae(Measurement::stature)), "stature, mean error",
              fmt::format("paper: {:.1f} mm, {} real people", kPaperStatureMaeMm, kPaperPeople)) +
         card(fmt::format("{:.1f} mm", mean_girth_mae(r)), "five girths, mean error",
              "chest, waist, hip, neck, shoulder") +
         card(fmt::format("{:.1f} kg", mae(Measurement::weight)), "weight, mean error", "from the shape alone") +
         card(fmt::format("{:.1f} %", 100 * r.sex_accuracy), "sex right",
              fmt::format("paper: {:.0f} of {}", kPaperSexRight * kPaperPeople, kPaperPeople)) +
         card(fmt::format("{:.1f} %", 100 * r.size_accuracy), "letter size right outright",
              fmt::format("paper: {:.1f} %; among our best two: {:.1f} %", 100 * kPaperSizeRight,
                          100 * r.size_top_two)) +
         card(fmt::format("{:.1f} %", 100 * mean_coverage(r)), "coverage of the 95 % interval",
              "mean of the measurements") +
         "</div>\n";
}

std::string cell(const std::string& text, const char* style = "") {
  return *style == '\0' ? "<td>" + text + "</td>" : fmt::format("<td class=\"{}\">{}</td>", style, text);
}

std::string mae_cell(const ErrorStatistics& s) {
  return cell(s.count > 0 ? fmt::format("{:.1f}", s.mae) : "–");
}

std::string table_of(const Report& r) {
  std::string html =
      "<div class=\"wide\"><table><tr><th></th><th>bias</th><th>MAE</th><th>SD</th><th>p95</th><th>max</th>"
      "<th>ISO 20685 mean</th><th>in 95 % interval</th><th>its width</th><th>nearest MAE</th><th>raw NN MAE</th>"
      "<th>paper MAE</th></tr>\n";
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const MeasurementReport& row = r.measurements[m];
    const ErrorStatistics& s = row.of(Estimator::ours);
    html += "<tr>" + cell(words_of(m) + ", " + std::string(kMeasurementTable[m].unit));
    if (!row.judged()) {
      for (int i = 0; i < 11; ++i) html += cell("–");
      html += "</tr>\n";
      continue;
    }
    for (const double value : {s.bias, s.mae, s.sd, s.p95, s.max}) html += cell(fmt::format("{:.1f}", value));
    const double limit = iso_20685_limit_mm(static_cast<Measurement>(m));
    const bool inside = within_iso_20685(s, static_cast<Measurement>(m));
    html +=
        limit > 0
            ? cell(fmt::format("{:.1f} to {:.1f} {} {:.0f}", s.mean_low, s.mean_high, inside ? "in" : "over", limit),
                   inside ? "in" : "over")
            : cell("–");
    const double covered = 100 * row.coverage();
    html += cell(fmt::format("{:.1f} %", covered), covered >= 93 && covered <= 97 ? "in" : "over");
    html += cell(fmt::format("{:.1f}", row.interval_width));
    html += mae_cell(row.of(Estimator::nearest)) + mae_cell(row.of(Estimator::raw)) +
            mae_cell(row.of(Estimator::paper)) + "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string groups_table(const Report& r) {
  std::string html =
      "<p>By sex and thirds of body mass index: bias / mean absolute error / share of truths in the "
      "95 % interval. Last row: how the error grows with body mass index, per kg/m², with its standard "
      "error.</p>\n<div class=\"wide\"><table><tr><th>people</th><th>number</th>";
  for (std::size_t m = 0; m < kMeasurementCount; ++m) html += "<th>" + words_of(m) + "</th>";
  html += "</tr>\n";
  for (const GroupReport& group : r.groups) {
    html += "<tr>" + cell(group.name) + cell(fmt::format("{}", group.people));
    for (const GroupReport::Row& row : group.rows)
      html += row.people == 0
                  ? cell("–")
                  : cell(fmt::format("{:+.1f} / {:.1f} / {:.0f} %", row.bias, row.mae, 100 * row.coverage),
                         row.coverage >= 0.9 && row.coverage <= 0.98 ? "in" : "over");
    html += "</tr>\n";
  }
  html += "<tr>" + cell("error by BMI") + cell(fmt::format("{}", r.measured));
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    html += cell(r.measurements[m].judged()
                     ? fmt::format("{:+.2f} ± {:.2f}", r.slopes[m].slope, r.slopes[m].standard_error)
                     : "–");
  return html + "</tr>\n</table></div>\n";
}

std::string conditions_table(const std::vector<ConditionRun>& runs) {
  std::string html = "<div class=\"wide\"><table><tr><th>condition</th><th>measured</th>";
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::string words = words_of(m);
    if (const std::size_t gap = words.find(' '); gap != words.npos) words.replace(gap, 1, "<br>");
    html += "<th>" + words + "</th>";
  }
  html += "<th>covered</th><th>sex</th><th>size</th><th>joints</th></tr>\n";
  for (const ConditionRun& run : runs) {
    const Report& r = run.report;
    html += fmt::format("<tr><td><b>{}</b><br><span class=\"quiet\">{}</span></td><td>{} of {}</td>",
                        escaped_for_xml(title_of(r)), escaped_for_xml(r.what), r.measured, r.subjects);
    for (const MeasurementReport& m : r.measurements) html += mae_cell(m.of(Estimator::ours));
    if (r.measured == 0) {
      html += cell("–") + cell("–") + cell("–") + cell("–") + "</tr>\n";
      continue;
    }
    html += cell(fmt::format("{:.1f} %", 100 * mean_coverage(r))) +
            cell(fmt::format("{:.1f} %", 100 * r.sex_accuracy)) +
            cell(fmt::format("{:.1f} %", 100 * r.size_accuracy)) + cell(fmt::format("{:.1f} mm", r.joint_error_mm)) +
            "</tr>\n";
  }
  return html + "</table></div>\n";
}

// People who were not measured, and the guidance they were given.
std::string refusals_of(const std::vector<ConditionRun>& runs) {
  std::string html;
  for (const ConditionRun& run : runs) {
    const Report& r = run.report;
    if (r.measured == r.subjects) continue;
    html += fmt::format("<p>{}: {} of {} not measured; guidance:", escaped_for_xml(title_of(r)),
                        r.subjects - r.measured, r.subjects);
    for (std::size_t g = 0; g < kGuidanceCount; ++g)
      if (r.not_measured_because[g] > 0)
        html += fmt::format(" {} ({})", kGuidanceNames[g], r.not_measured_because[g]);
    html += ".</p>\n";
  }
  return html;
}

std::string section(const std::string& id, const std::string& heading, const std::string& inside) {
  return fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", id, escaped_for_xml(heading), inside);
}

}  // namespace

std::vector<Figure> figures_of(const FullReport& report) {
  std::vector<Figure> figures;
  const ConditionRun& first = report.runs.front();
  if (first.report.measured > 0) {
    figures.push_back(distribution_figure(first));
    figures.push_back(height_error_figure(first));
    figures.push_back(sex_and_size_figure(first));
  }
  figures.push_back(conditions_figure(report.runs));
  figures.push_back(calibration_figure(report.runs));
  if (first.report.measured > 0) {
    figures.push_back(bias_figure(first));
    figures.push_back(agreement_figure(first));
    if (first.report.has_repeats()) figures.push_back(repeatability_figure(first));
  }
  if (!report.runtime.empty() || !report.references.empty())
    figures.push_back(runtime_figure(report.runtime, report.references));
  if (!report.icp.empty()) figures.push_back(icp_figure(report.icp));
  return figures;
}

std::string html_of(const FullReport& report) {
  const Report& first = report.runs.front().report;
  const std::vector<Figure> figures = figures_of(report);
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>im2fit: how well it measures</title>\n<style>" +
      std::string(kPageStyle) + "</style></head>\n<body><main>\n<h1>How well im2fit measures</h1>\n";
  html += fmt::format(
      "<p><span class=\"synthetic\">synthetic</span> {} people of a family no index was built of, seen by a virtual "
      "Kinect, through the whole device path; the truth is measured on their meshes by ISO 8559-1. None of it is a "
      "claim "
      "against a tape. Condition of the figures: <b>{}</b>, {}.</p>\n<p class=\"quiet\">{}</p>\n",
      first.subjects, escaped_for_xml(title_of(first)), escaped_for_xml(first.what),
      escaped_for_xml(report.provenance));
  if (first.measured > 0) html += cards_of(first);
  html += "<nav>";
  for (const Figure& figure : figures) html += fmt::format("<a href=\"#{}\">{}</a>", figure.id, figure.id);
  html += "<a href=\"#tables\">tables</a></nav>\n";
  for (const Figure& figure : figures)
    html += section(figure.id, figure.heading, "<p>" + figure.words + "</p>\n" + figure.picture.embedded());
  html += section("tables", "Every measurement, " + title_of(first), first.measured > 0 ? table_of(first) : "");
  if (first.measured > 0) html += section("table-groups", "Errors by sex and build", groups_table(first));
  html += section("table-conditions", "Mean absolute error by condition",
                  conditions_table(report.runs) + refusals_of(report.runs));
  return html + "</main></body></html>\n";
}

std::string json_of(const FullReport& report) {
  using Json = nlohmann::ordered_json;
  Json json = {{"schema", "im2fit.evaluation-set/1"}, {"label", "synthetic"}, {"provenance", report.provenance}};
  json["conditions"] = Json::array();
  for (const ConditionRun& run : report.runs) json["conditions"].push_back(json_value_of(run.report));
  for (const RuntimeRow& row : report.runtime)
    json["runtime"].push_back({{"file", row.file},
                               {"models", row.models},
                               {"query_p50_ms", row.query_p50_ms},
                               {"query_p99_ms", row.query_p99_ms},
                               {"measurements_ms", row.measurements_ms},
                               {"naked_ms", row.naked_ms > 0 ? Json(row.naked_ms) : Json()},
                               {"clothed_ms", row.clothed_ms > 0 ? Json(row.clothed_ms) : Json()}});
  for (const IcpCurve& c : report.icp)
    json["icp"].push_back({{"method", c.method}, {"who", c.who}, {"error_mm", c.error_mm}});
  return json.dump(1) + "\n";
}

}  // namespace im2fit::lab
