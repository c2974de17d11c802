// SPDX-License-Identifier: Apache-2.0
#include "evaluation/study/calibrate.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "evaluation/measurements/error_statistics.h"
#include "formats/json_file.h"

namespace im2fit::lab {
namespace {

using Json = nlohmann::ordered_json;

// A correction of values must be seen to help by so many standard errors of its help.
constexpr double kGainErrors = 1;
// Widths alone are worth a file when the coverage of people left out comes nearer to 95 % by so much.
constexpr double kCoverageGain = 0.01;
constexpr double kStated = 0.95;

// Takes out tape values that are slips of the pen.
std::vector<std::string> leave_slips_aside(std::vector<SitePerson>& people) {
  std::vector<std::string> aside;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    // In the answer's own SDs: the heaviest person's weight is known worse than others'.
    const auto sds_off = [m](const SitePerson& p) { return p.error(m) / answer_sd(p.answer[m]); };
    std::vector<double> errors;
    for (const SitePerson& p : people)
      if (p.tape[m].taken()) errors.push_back(sds_off(p));
    if (static_cast<int>(errors.size()) < kCalibrationPeopleMin) continue;
    const double median = box_statistics(errors).median;
    for (double& e : errors) e = std::abs(e - median);
    const double sd = 1.4826 * box_statistics(errors).median;
    if (!(sd > 0)) continue;
    for (SitePerson& p : people) {
      if (!p.tape[m].taken() || !(std::abs(sds_off(p) - median) > kSlipSds * sd)) continue;
      aside.push_back(fmt::format("{}: {} {:.1f}, estimated {:.1f}", p.person, kMeasurementTable[m].id,
                                  p.tape[m].mean(), p.answer[m].value));
      p.tape[m] = {};
    }
  }
  return aside;
}

// Everybody by a model of all others, with values corrected and without.
struct Judged {
  std::array<LeftOut, kMeasurementCount> rows{};
  double gain = 0, gain_se = 0, coverage_before = 0, coverage_after = 0;
};

Judged judge(const std::vector<const SitePerson*>& people, const std::vector<SiteModel>& without, bool values) {
  Judged judged;
  std::vector<double> gains;
  int inside_before = 0, inside_after = 0, all = 0;
  for (std::size_t i = 0; i < people.size(); ++i) {
    const SitePerson& p = *people[i];
    double gain = 0;
    int count = 0;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      if (!p.tape[m].taken() || without[i].rows[m].people == 0) continue;
      const double truth = p.tape[m].mean();
      const index::IntervalEstimate after = corrected(without[i], p, m, values);
      const double error = p.error(m), left = static_cast<double>(after.value) - truth;
      LeftOut& row = judged.rows[m];
      ++row.people;
      row.bias_before += error;
      row.bias_after += left;
      row.mae_before += std::abs(error);
      row.mae_after += std::abs(left);
      row.coverage_before += holds(p.answer[m], truth) ? 1 : 0;
      row.coverage_after += holds(after, truth) ? 1 : 0;
      inside_before += holds(p.answer[m], truth) ? 1 : 0;
      inside_after += holds(after, truth) ? 1 : 0;
      ++all;
      ++count;
      gain += (std::abs(error) - std::abs(left)) / answer_sd(p.answer[m]);
    }
    if (count > 0) gains.push_back(gain / count);
  }
  for (LeftOut& row : judged.rows)
    for (double* sum : {&row.bias_before, &row.bias_after, &row.mae_before, &row.mae_after, &row.coverage_before,
                        &row.coverage_after})
      if (row.people > 0) *sum /= row.people;
  const ErrorStatistics s = error_statistics(gains);
  judged.gain = s.bias;
  if (s.count > 1) judged.gain_se = s.sd / std::sqrt(static_cast<double>(s.count));
  if (all > 0) {
    judged.coverage_before = static_cast<double>(inside_before) / all;
    judged.coverage_after = static_cast<double>(inside_after) / all;
  }
  return judged;
}

void take(const Judged& judged, bool values, CalibrationOutcome& outcome) {
  outcome.values = values;
  outcome.rows = judged.rows;
  outcome.gain = judged.gain;
  outcome.gain_se = judged.gain_se;
  outcome.coverage_before = judged.coverage_before;
  outcome.coverage_after = judged.coverage_after;
}

// The factor of all widths at which 95 % of the truths of people left out lie inside: the tails of errors are not
// those of a normal distribution. Drawn to 1 as if this number of people had shown 1 before.
constexpr double kWidthPeople = 8;
double width_factor(const std::vector<const SitePerson*>& people, const std::vector<SiteModel>& without,
                    bool values) {
  std::vector<double> shares;  // of the way to the interval's end
  for (std::size_t i = 0; i < people.size(); ++i)
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      if (!people[i]->tape[m].taken() || without[i].rows[m].people == 0) continue;
      const index::IntervalEstimate e = corrected(without[i], *people[i], m, values);
      const double off = people[i]->tape[m].mean() - static_cast<double>(e.value);
      const double reach = off > 0 ? static_cast<double>(e.high - e.value) : static_cast<double>(e.value - e.low);
      shares.push_back(std::abs(off) / std::max(1e-3, reach));
    }
  if (shares.empty()) return 1;
  std::sort(shares.begin(), shares.end());
  const auto n = static_cast<double>(people.size());
  return std::pow(quantile(shares, kStated), n / (n + kWidthPeople));
}

void widen(SiteModel& model, double of_values, double alone) {
  for (SiteModel::Row& row : model.rows) {
    row.width *= of_values;
    row.width_alone *= alone;
  }
}

double miss(double coverage) {
  return std::abs(coverage - kStated);
}

// What a device would refuse to read.
std::string out_of_range(const CalibrationOutcome& outcome) {
  const auto file = site_calibration(outcome, "site", 0).file();
  return file ? ""
              : file.error().message + "; check for a wrong unit, or for a camera that needs its own calibration";
}

Json spreads_json(const SiteSpreads& s) {
  return {{"offset", s.offset}, {"sex", s.sex},     {"slope", s.slope},
          {"scale", s.scale},   {"girth", s.girth}, {"camera", s.camera}};
}

}  // namespace

std::vector<SitePerson> one_visit_each(const std::vector<SitePerson>& people) {
  std::map<std::string, std::size_t> last;
  for (std::size_t i = 0; i < people.size(); ++i) last[people[i].person] = i;
  std::vector<SitePerson> each;
  for (std::size_t i = 0; i < people.size(); ++i)
    if (last[people[i].person] == i) each.push_back(people[i]);
  return each;
}

CalibrationOutcome calibrate(const std::vector<SitePerson>& people) {
  CalibrationOutcome outcome;
  std::vector<SitePerson> visits = one_visit_each(people);
  outcome.left_aside = leave_slips_aside(visits);
  std::vector<const SitePerson*> all;
  for (const SitePerson& p : visits)
    if (std::any_of(p.tape.begin(), p.tape.end(), [](const TapeReadings& t) { return t.taken(); })) all.push_back(&p);
  outcome.people = static_cast<int>(all.size());
  if (outcome.people < kCalibrationPeopleMin) {
    outcome.refusal =
        fmt::format("{} people with tape values are too few; at least {} are needed, 20 or more are better",
                    outcome.people, kCalibrationPeopleMin);
    return outcome;
  }
  outcome.model = fit_site_model(all, kCalibrationPeopleMin);
  if (std::none_of(outcome.model.rows.begin(), outcome.model.rows.end(),
                   [](const SiteModel::Row& row) { return row.people > 0; })) {
    outcome.refusal = fmt::format("no measurement has tape values of {} people", kCalibrationPeopleMin);
    return outcome;
  }
  // Whoever is left out leaves the rest one fewer than the least.
  std::vector<SiteModel> without;
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<const SitePerson*> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    without.push_back(fit_site_model(others, kCalibrationPeopleMin - 1));
  }
  const double of_values = width_factor(all, without, true), alone = width_factor(all, without, false);
  widen(outcome.model, of_values, alone);
  for (SiteModel& model : without) widen(model, of_values, alone);
  const Judged with_values = judge(all, without, true), widths_alone = judge(all, without, false);
  if (with_values.gain > kGainErrors * with_values.gain_se) {
    take(with_values, true, outcome);
    outcome.refusal = out_of_range(outcome);
    return outcome;
  }
  if (miss(widths_alone.coverage_after) < miss(widths_alone.coverage_before) - kCoverageGain) {
    take(widths_alone, false, outcome);
    outcome.refusal = out_of_range(outcome);
    return outcome;
  }
  take(with_values, true, outcome);
  outcome.refusal = fmt::format(
      "it would not help: of people left out the mean error would change by {:+.3f} +- {:.3f} of the estimate's own "
      "SD, and "
      "{:.1f} % instead of {:.1f} % of the intervals would hold the truth",
      -outcome.gain, outcome.gain_se, 100 * widths_alone.coverage_after, 100 * widths_alone.coverage_before);
  return outcome;
}

SiteCalibration site_calibration(const CalibrationOutcome& outcome, const std::string& name,
                                 std::uint32_t index_crc32c) {
  SiteCalibration site;
  site.name = name;
  site.people = static_cast<std::uint32_t>(outcome.people);
  site.index_crc32c = index_crc32c;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const SiteModel::Row& row = outcome.model.rows[m];
    if (row.people == 0) continue;
    site.row_people[m] = static_cast<std::uint32_t>(row.people);
    if (outcome.values)
      site.rows[m] = {row.scale, row.offset_men, row.offset_women, row.width};
    else
      site.rows[m].width = row.width_alone;
  }
  if (outcome.values)
    for (const SiteModel::Camera& camera : outcome.model.cameras) site.cameras.push_back({camera.name, camera.scale});
  return site;
}

std::string text_of(const CalibrationOutcome& outcome) {
  std::string text = fmt::format("{} people\n", outcome.people);
  for (const std::string& slip : outcome.left_aside) text += "left out, perhaps a typing error: " + slip + "\n";
  if (outcome.model.rows[0].people > 0 || outcome.gain_se > 0) {
    text += fmt::format("\n{:17}{:>7}{:>16}{:>9}{:>16}{:>14}\n", "people left out", "people", "bias", "", "MAE",
                        "in 95 %");
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const LeftOut& row = outcome.rows[m];
      if (row.people == 0) continue;
      text += fmt::format("{:17}{:>7}{:>+10.1f} ->{:>+6.1f}{:>13.1f} ->{:>6.1f}{:>8.0f} ->{:>4.0f}\n",
                          kMeasurementTable[m].id, row.people, row.bias_before, row.bias_after, row.mae_before,
                          row.mae_after, 100 * row.coverage_before, 100 * row.coverage_after);
    }
    const SiteSpreads& s = outcome.model.spreads;
    text += fmt::format(
        "\nall: error smaller by {:.3f} +- {:.3f} of the estimate's own SD; in 95 %: {:.1f} -> {:.1f}\n"
        "this site differs by: scale {:.2f} %, girths {:.2f} %, offset {:.2f} and sex {:.2f} of ISO 20685's\n"
        "allowance, slope {:.1f} %, cameras {:.2f} % (SDs, estimated from the sessions)\n",
        outcome.gain, outcome.gain_se, 100 * outcome.coverage_before, 100 * outcome.coverage_after, 100 * s.scale,
        100 * s.girth, s.offset, s.sex, 100 * s.slope, 100 * s.camera);
  }
  if (!outcome.refusal.empty()) return text + "\nno calibration: " + outcome.refusal + "\n";
  return text + (outcome.values ? "\ncalibration of values and intervals\n" : "\ncalibration of intervals alone\n");
}

std::string json_of(const CalibrationOutcome& outcome) {
  Json json = {{"schema", "im2fit.calibration/1"},
               {"people", outcome.people},
               {"left_aside", outcome.left_aside},
               {"refusal", outcome.refusal.empty() ? Json(nullptr) : Json(outcome.refusal)},
               {"corrects", !outcome.refusal.empty() ? "nothing"
                            : outcome.values         ? "values"
                                                     : "widths"},
               {"gain", outcome.gain},
               {"gain_se", outcome.gain_se},
               {"coverage", {{"before", outcome.coverage_before}, {"after", outcome.coverage_after}}},
               {"spreads", spreads_json(outcome.model.spreads)},
               {"measurements", Json::object()},
               {"cameras", Json::object()}};
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const LeftOut& r = outcome.rows[m];
    const SiteModel::Row& row = outcome.model.rows[m];
    if (row.people == 0) continue;
    json["measurements"][std::string(kMeasurementTable[m].id)] = {
        {"people", row.people},
        {"scale", outcome.values ? row.scale : 1.0},
        {"offset_men", outcome.values ? row.offset_men : 0.0},
        {"offset_women", outcome.values ? row.offset_women : 0.0},
        {"width", outcome.values ? row.width : row.width_alone},
        {"left_out",
         {{"bias", {r.bias_before, r.bias_after}},
          {"mae", {r.mae_before, r.mae_after}},
          {"coverage", {r.coverage_before, r.coverage_after}}}}};
  }
  for (const SiteModel::Camera& camera : outcome.model.cameras) json["cameras"][camera.name] = camera.scale;
  return json_text(json, 2) + "\n";
}

}  // namespace im2fit::lab
