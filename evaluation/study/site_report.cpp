// SPDX-License-Identifier: Apache-2.0
#include "evaluation/study/site_report.h"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/measurements/figures.h"
#include "evaluation/measurements/paper_says.h"
#include "evaluation/study/calibrate.h"
#include "formats/json_file.h"
#include "report/page_style.h"

namespace im2fit::lab {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kStature = measurement_index(Measurement::stature);

std::string share_words(const Share& share) {
  return fmt::format("{:.1f} % ({:.0f}-{:.0f})", 100 * share.value, 100 * share.low, 100 * share.high);
}

// "40 more people", "its bias must go first", "yes".
std::string claim_words(const MeasurementStudy& m) {
  if (m.allowance_mm <= 0) return "no allowance";
  if (m.people_for_claim == 0) return "bias too large";
  if (m.errors.count >= m.people_for_claim && m.within) return "yes";
  return fmt::format("{} more", std::max(1, m.people_for_claim - m.errors.count));
}

const ErrorFigures& best(const MeasurementStudy& m) {
  return m.tape_known ? m.tape_out : m.as_taken;
}

Json share_json(const Share& share) {
  return {{"hits", share.hits}, {"count", share.count}, {"interval", {share.low, share.high}}};
}
Json figures_json(const ErrorFigures& f) {
  return {{"sd", f.sd},
          {"mae", f.mae},
          {"limits_of_agreement", {f.agreement_low, f.agreement_high}},
          {"coverage", share_json(f.covered)}};
}

// The evaluation's figures are made of outcomes; a truth that is not known is not-a-number there.
ConditionRun as_run(const std::vector<SitePerson>& people, const SiteStudy& study, bool with_stature) {
  ConditionRun run;
  for (const SitePerson& p : people) {
    if (with_stature && !p.tape[kStature].taken()) continue;
    Outcome o;
    o.measured = true;
    o.woman = p.woman.value_or(p.female > 0.5);
    o.answer.measurements = p.answer;
    o.answer.female = static_cast<float>(p.female);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) o.truth[m] = static_cast<float>(p.tape[m].mean());
    run.outcomes.push_back(o);
  }
  run.report.measured = static_cast<int>(run.outcomes.size());
  run.report.subjects = run.report.measured;
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    run.report.measurements[m].errors[static_cast<std::size_t>(Estimator::ours)] = study.measurements[m].errors;
  return run;
}

std::string cell(const std::string& words, const char* style = "") {
  return *style != '\0' ? fmt::format("<td class=\"{}\">{}</td>", style, escaped_for_xml(words))
                        : fmt::format("<td>{}</td>", escaped_for_xml(words));
}

std::string section(const std::string& heading, const std::string& inside) {
  return fmt::format("<section><h2>{}</h2>\n{}</section>\n", escaped_for_xml(heading), inside);
}

std::string measurements_table(const SiteStudy& study) {
  std::string html =
      "<div class=\"wide\"><table><tr><th>measurement</th><th>people</th><th>bias</th><th>95 % of it</th><th>ISO "
      "20685</th>"
      "<th>for the claim</th><th>MAE</th><th>SD</th><th>limits of agreement</th><th>TEM of the tape (pairs)</th>"
      "<th>in the 95 % interval</th><th>its width</th></tr>\n";
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const MeasurementStudy& m = study.measurements[i];
    if (m.errors.count == 0) continue;
    const ErrorFigures& f = best(m);
    html += "<tr>" + cell(words_of(i) + ", " + std::string(kMeasurementTable[i].unit) + (m.tape_known ? " *" : ""));
    html += cell(fmt::format("{}", m.errors.count)) + cell(fmt::format("{:+.1f}", m.errors.bias));
    html += cell(fmt::format("{:+.1f} to {:+.1f}", m.errors.mean_low, m.errors.mean_high));
    html += m.allowance_mm > 0 ? cell(fmt::format("{} {:.0f}", m.within ? "within" : "over", m.allowance_mm),
                                      m.within ? "in" : "over")
                               : cell("");
    html += cell(claim_words(m)) + cell(fmt::format("{:.1f}", f.mae)) + cell(fmt::format("{:.1f}", f.sd));
    html += cell(fmt::format("{:+.1f} to {:+.1f}", f.agreement_low, f.agreement_high));
    html += cell(m.tape.pairs > 0 ? fmt::format("{:.1f} ({})", m.tape.tem, m.tape.pairs) : "once");
    html += cell(share_words(f.covered), f.covered.low <= 0.95 && f.covered.high >= 0.95 ? "in" : "over");
    html += cell(fmt::format("{:.1f}", m.interval_width)) + "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string groups_table(const SiteStudy& study) {
  std::string html = "<div class=\"wide\"><table><tr><th>bias / MAE / covered</th><th>people</th>";
  for (std::size_t m = 0; m < kMeasurementCount; ++m) html += "<th>" + words_of(m) + "</th>";
  html += "</tr>\n";
  for (const StudyGroup& group : study.groups) {
    html += "<tr>" + cell(group.name) + cell(fmt::format("{}", group.people));
    for (const StudyGroup::Row& row : group.rows)
      html += row.count == 0
                  ? cell("")
                  : cell(fmt::format("{:+.1f} / {:.1f} / {:.0f} %", row.bias, row.mae, 100 * row.covered.value),
                         row.covered.low <= 0.95 && row.covered.high >= 0.95 ? "" : "over");
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string card(const std::string& what, const std::string& figure, const std::string& beside) {
  return fmt::format("<div class=\"card\"><span>{}</span><b>{}</b><span>{}</span></div>\n", what, figure, beside);
}

std::string cards_of(const SiteStudy& study) {
  std::string html = "<div class=\"cards\">\n";
  html += card("people", fmt::format("{}", study.people),
               fmt::format("{} visits; the paper had {}", study.visits, kPaperPeople));
  if (const MeasurementStudy& m = study.measurements[kStature]; m.errors.count > 0)
    html += card("height is off by", fmt::format("{:.1f} mm", m.as_taken.mae),
                 fmt::format("mean; the paper: {:.1f} mm", kPaperStatureMaeMm));
  if (study.sex_right.count > 0)
    html += card("sex right", fmt::format("{:.1f} %", 100 * study.sex_right.value),
                 fmt::format("{:.0f} to {:.0f} %; the paper: {:.0f} %", 100 * study.sex_right.low,
                             100 * study.sex_right.high, 100 * kPaperSexRight));
  if (study.size_right.count > 0)
    html += card("size as worn", fmt::format("{:.1f} %", 100 * study.size_right.value),
                 fmt::format("{:.0f} to {:.0f} %; the paper: {:.1f} %", 100 * study.size_right.low,
                             100 * study.size_right.high, 100 * kPaperSizeRight));
  return html + "</div>\n";
}

}  // namespace

std::string text_of(const SiteStudy& study) {
  std::string text = fmt::format("{} people, {} visits\n\n", study.people, study.visits);
  text += "mm, kg             people    bias     MAE      SD  in 95 %        ISO 20685  for the claim\n";
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const MeasurementStudy& m = study.measurements[i];
    if (m.errors.count == 0) continue;
    const ErrorFigures& f = best(m);
    text += fmt::format(
        "{:18}{}{:>6}{:>+8.1f}{:>8.1f}{:>8.1f}  {:<15}{:<11}{}\n", kMeasurementTable[i].id, m.tape_known ? "*" : " ",
        m.errors.count, m.errors.bias, f.mae, f.sd,
        fmt::format("{:.0f} ({:.0f}-{:.0f})", 100 * f.covered.value, 100 * f.covered.low, 100 * f.covered.high),
        m.allowance_mm > 0 ? fmt::format("{} {:.0f}", m.within ? "within" : "over", m.allowance_mm) : "",
        claim_words(m));
  }
  text += "* the tape's own error is taken out of MAE, SD and coverage\n";
  if (study.sex_right.count > 0)
    text += fmt::format("sex right   {} of {}: {}\n", study.sex_right.hits, study.sex_right.count,
                        share_words(study.sex_right));
  if (study.size_right.count > 0)
    text += fmt::format("size right  {} of {}: {}\n", study.size_right.hits, study.size_right.count,
                        share_words(study.size_right));
  return text;
}

std::string json_of(const SiteStudy& study) {
  Json json = {{"schema", "im2fit.study/1"}, {"people", study.people}, {"visits", study.visits}};
  json["measurements"] = Json::object();
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const MeasurementStudy& m = study.measurements[i];
    if (m.errors.count == 0) continue;
    Json row = {{"people", m.errors.count},
                {"bias", m.errors.bias},
                {"bias_interval", {m.errors.mean_low, m.errors.mean_high}},
                {"as_taken", figures_json(m.as_taken)},
                {"interval_width", m.interval_width}};
    if (m.tape.pairs > 0)
      row["tape"] = {{"pairs", m.tape.pairs}, {"tem", m.tape.tem}, {"reliability", m.tape.reliability}};
    if (m.tape_known) row["tape_error_out"] = figures_json(m.tape_out);
    if (m.allowance_mm > 0)
      row["iso_20685"] = {{"allowance", m.allowance_mm},
                          {"within", m.within},
                          {"people_for_claim", m.people_for_claim > 0 ? Json(m.people_for_claim) : Json()}};
    json["measurements"][std::string(kMeasurementTable[i].id)] = row;
  }
  json["sex"] = share_json(study.sex_right);
  json["size"] = share_json(study.size_right);
  json["groups"] = Json::array();
  for (const StudyGroup& group : study.groups) {
    Json rows = Json::object();
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      if (group.rows[m].count > 0)
        rows[std::string(kMeasurementTable[m].id)] = {{"bias", group.rows[m].bias},
                                                      {"mae", group.rows[m].mae},
                                                      {"coverage", share_json(group.rows[m].covered)}};
    json["groups"].push_back({{"name", group.name}, {"people", group.people}, {"measurements", rows}});
  }
  return json_text(json, 2) + "\n";
}

std::string html_of(const SiteStudy& study, const std::vector<SitePerson>& visits, const std::string& title,
                    bool synthetic) {
  const std::vector<SitePerson> people = one_visit_each(visits);
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>im2fit: " +
      escaped_for_xml(title) + "</title>\n<style>" + kPageStyle + "</style></head>\n<body><main>\n<h1>" +
      escaped_for_xml(title) + "</h1>\n";
  html +=
      synthetic
          ? "<p><span class=\"synthetic\">synthetic</span> simulated people and a simulated tape: no claim against a "
            "real one.</p>\n"
          : "<p>Estimates against tape and scale for the same people.</p>\n";
  html += cards_of(study);
  const ConditionRun all = as_run(people, study, false), tall = as_run(people, study, true);
  if (!tall.outcomes.empty()) {
    const Figure heights = height_error_figure(tall);
    html += section(heights.heading, "<p>" + heights.words + "</p>\n" + heights.picture.embedded());
  }
  if (!all.outcomes.empty()) {
    const Figure boxes = distribution_figure(all);
    html += section(boxes.heading, "<p>" + boxes.words + "</p>\n" + boxes.picture.embedded());
  }
  html += section(
      "Every measurement",
      fmt::format(
          "<p>Error: estimate minus tape. * where the tape was taken twice by {} people or more: its own error "
          "(TEM) is taken out of MAE, SD, limits and coverage. ISO 20685 wants the 95 % interval of the "
          "bias within its allowance, in a test of {} people or more.</p>\n",
          kTapePairsMin, kIsoPeopleMin) +
          measurements_table(study));
  if (!study.groups.empty()) html += section("Errors by sex and build", groups_table(study));
  return html + "</main></body></html>\n";
}

}  // namespace im2fit::lab
