// SPDX-License-Identifier: Apache-2.0
#include "evaluation/study/calibration_trials.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/rng.h"
#include "evaluation/measurements/error_statistics.h"
#include "evaluation/study/calibrate.h"

namespace im2fit::lab {
namespace {

// Means over measurements, of people who had no part.
struct Judgement {
  double bias_before = 0, bias_after = 0, mae_before = 0, mae_after = 0, coverage_before = 0, coverage_after = 0;
};

Judgement judge(const CalibrationOutcome& outcome, const std::vector<const SitePerson*>& fresh) {
  Judgement judgement;
  const bool corrects = outcome.refusal.empty();
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::vector<double> before, after;
    double sd = 0;
    int held_before = 0, held_after = 0;
    for (const SitePerson* p : fresh) {
      if (!p->tape[m].taken()) continue;
      const double truth = p->tape[m].mean();
      const index::IntervalEstimate e = corrects ? corrected(outcome.model, *p, m, outcome.values) : p->answer[m];
      before.push_back(p->error(m));
      after.push_back(static_cast<double>(e.value) - truth);
      sd += answer_sd(p->answer[m]);
      held_before += holds(p->answer[m], truth) ? 1 : 0;
      held_after += holds(e, truth) ? 1 : 0;
    }
    const ErrorStatistics b = error_statistics(before), a = error_statistics(after);
    if (b.count == 0) continue;
    const double n = b.count;
    sd /= n;
    judgement.bias_before += std::abs(b.bias) / sd / kMeasurementCount;
    judgement.bias_after += std::abs(a.bias) / sd / kMeasurementCount;
    judgement.mae_before += b.mae / sd / kMeasurementCount;
    judgement.mae_after += a.mae / sd / kMeasurementCount;
    judgement.coverage_before += held_before / n / kMeasurementCount;
    judgement.coverage_after += held_after / n / kMeasurementCount;
  }
  return judgement;
}

}  // namespace

CalibrationTrial try_calibrations(const std::string& site, const std::vector<SitePerson>& pool, int people, int draws,
                                  std::uint64_t seed) {
  CalibrationTrial trial;
  trial.site = site;
  trial.people = people;
  trial.draws = draws;
  trial.coverage_least = 1;
  trial.mae_change_worst = -1;
  std::vector<double> off;
  for (int draw = 0; draw < draws; ++draw) {
    Rng rng = Rng::for_item(seed, static_cast<std::uint64_t>(people), static_cast<std::uint64_t>(draw));
    std::vector<const SitePerson*> order;
    for (const SitePerson& p : pool) order.push_back(&p);
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(rng.index(static_cast<int>(i)))]);
    std::vector<SitePerson> learned;
    for (int i = 0; i < people; ++i) learned.push_back(*order[static_cast<std::size_t>(i)]);
    const CalibrationOutcome outcome = calibrate(learned);
    if (outcome.refusal.empty()) ++(outcome.values ? trial.values : trial.widths);
    const Judgement j = judge(outcome, {order.begin() + people, order.end()});
    trial.bias_before += j.bias_before / draws;
    trial.bias_after += j.bias_after / draws;
    trial.mae_before += j.mae_before / draws;
    trial.mae_after += j.mae_after / draws;
    trial.coverage_before += j.coverage_before / draws;
    trial.coverage_after += j.coverage_after / draws;
    trial.coverage_least = std::min(trial.coverage_least, j.coverage_after);
    trial.coverage_most = std::max(trial.coverage_most, j.coverage_after);
    trial.mae_change_worst = std::max(trial.mae_change_worst, j.mae_after / j.mae_before - 1);
    off.push_back(1 - j.bias_after / j.bias_before);
  }
  std::sort(off.begin(), off.end());
  if (off.empty()) return trial;
  trial.bias_off_least = off.front();
  trial.bias_off_median = quantile(off, 0.5);
  return trial;
}

std::vector<SitePerson> without_bias(std::vector<SitePerson> pool) {
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::vector<double> errors;
    for (const SitePerson& p : pool) errors.push_back(p.error(m));
    const double bias = error_statistics(errors).bias;
    for (SitePerson& p : pool) {
      p.tape[m].first += bias;
      p.tape[m].second += bias;
    }
  }
  return pool;
}

std::string text_of(const std::vector<CalibrationTrial>& trials) {
  std::string text =
      "site     people   bias, SDs     off %  least   MAE, SDs      worst %  in 95 %        of a draw    values\n";
  for (const CalibrationTrial& t : trials)
    text += fmt::format(
        "{:8}{:>7}   {:.2f} -> {:.2f}{:>7.0f}{:>7.0f}   {:.2f} -> {:.2f}{:>+9.1f}  {:.1f} -> {:.1f}   {:.1f}-{:.1f}"
        "{:>7}/{}\n",
        t.site, t.people, t.bias_before, t.bias_after, 100 * t.bias_off_median, 100 * t.bias_off_least, t.mae_before,
        t.mae_after, 100 * t.mae_change_worst, 100 * t.coverage_before, 100 * t.coverage_after,
        100 * t.coverage_least, 100 * t.coverage_most, t.values, t.draws);
  return text;
}

std::string json_of(const std::vector<CalibrationTrial>& trials) {
  nlohmann::ordered_json json = {{"schema", "im2fit.calibration-trials/1"}, {"label", "synthetic"}};
  json["trials"] = nlohmann::ordered_json::array();
  for (const CalibrationTrial& t : trials)
    json["trials"].push_back({{"site", t.site},
                              {"people", t.people},
                              {"draws", t.draws},
                              {"bias_sds", {t.bias_before, t.bias_after}},
                              {"bias_off", {{"median", t.bias_off_median}, {"least", t.bias_off_least}}},
                              {"mae_sds", {t.mae_before, t.mae_after}},
                              {"mae_change_worst", t.mae_change_worst},
                              {"coverage", {t.coverage_before, t.coverage_after}},
                              {"coverage_of_a_draw", {t.coverage_least, t.coverage_most}},
                              {"corrects_values", t.values},
                              {"corrects_widths", t.widths}});
  return json.dump(2) + "\n";
}

}  // namespace im2fit::lab
