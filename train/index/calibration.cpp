// SPDX-License-Identifier: Apache-2.0
#include "train/index/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace im2fit::index {
namespace {

constexpr double kAlpha = 0.05;
constexpr double kSpreadMin = 1e-6;  // standardised: a measurement that never varies has no error either

double width_of(const IntervalModel& model, const HeldOut& row, std::size_t m) {
  const auto floor = static_cast<double>(model.spread_floor[m]);
  const double base = model.kind == IntervalKind::local_spread ? 0.5 * (floor + row.spread[m]) : floor;
  return base * model.noise.width(row.frame_count, row.distance_mm, row.novelty);
}

double error_of(const HeldOut& row, std::size_t m) {
  return row.truth[m] - row.answer[m];
}

// Empirical quantiles with the finite-sample rank of conformal prediction.
void fit_quantiles(IntervalModel& model, const std::vector<const HeldOut*>& rows) {
  std::vector<double> scores(rows.size());
  const auto n = static_cast<double>(rows.size());
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    for (std::size_t i = 0; i < rows.size(); ++i) scores[i] = error_of(*rows[i], m) / width_of(model, *rows[i], m);
    std::sort(scores.begin(), scores.end());
    const double low = std::floor((n + 1) * kAlpha / 2) - 1;
    const double high = std::ceil((n + 1) * (1 - kAlpha / 2)) - 1;
    const auto at = [&](double rank) { return scores[static_cast<std::size_t>(std::clamp(rank, 0.0, n - 1))]; };
    model.quantiles[2 * m] = static_cast<float>(std::min(at(low), 0.0));
    model.quantiles[2 * m + 1] = static_cast<float>(std::max(at(high), 0.0));
  }
}

// Mean interval score over the measurements: width plus 2/alpha times the miss.
double interval_score(const IntervalModel& model, const std::vector<const HeldOut*>& rows) {
  double sum = 0;
  for (const HeldOut* row : rows)
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const double width = width_of(model, *row, m);
      const double low = width * static_cast<double>(model.quantiles[2 * m]);
      const double high = width * static_cast<double>(model.quantiles[2 * m + 1]);
      const double e = error_of(*row, m);
      const double miss = e < low ? low - e : e > high ? e - high : 0.0;
      sum += (high - low + 2 / kAlpha * miss) / static_cast<double>(model.spread_floor[m]);
    }
  return sum;
}

// Least squares of squared errors against the terms of the noise, none of them below zero: the normal equations,
// solved term by term. Where no term explains more than the mean does, the mean it is.
NoiseModel fit_noise(const IntervalModel& model, const std::vector<HeldOut>& rows) {
  constexpr int kRounds = 1000;
  constexpr double kConstantMin = 0.01;  // of the mean: no width is zero
  std::array<std::array<double, kNoiseTerms>, kNoiseTerms> gram{};
  std::array<double, kNoiseTerms> cross{};
  for (const HeldOut& row : rows) {
    const auto terms = noise_terms(row.frame_count, row.distance_mm, row.novelty);
    double square = 0;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const double e = error_of(row, m) / static_cast<double>(model.spread_floor[m]);
      square += std::min(e * e, 16.0) / kMeasurementCount;  // a few wild answers must not decide
    }
    for (std::size_t i = 0; i < kNoiseTerms; ++i) {
      cross[i] += terms[i] * square;
      for (std::size_t j = 0; j < kNoiseTerms; ++j) gram[i][j] += terms[i] * terms[j];
    }
  }
  const double mean = cross[0] / gram[0][0];
  if (!(mean > 0)) return {};
  NoiseModel noise;
  auto& share = noise.share;
  share[0] = mean;
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < kNoiseTerms; ++i) {
      if (gram[i][i] <= 0) continue;
      double rest = cross[i];
      for (std::size_t j = 0; j < kNoiseTerms; ++j) rest -= j == i ? 0 : gram[i][j] * share[j];
      share[i] = std::max(rest / gram[i][i], i == 0 ? kConstantMin * mean : 0.0);
    }
  for (double& s : share) s /= mean;
  return noise;
}

}  // namespace

std::vector<std::size_t> ood_beside(std::size_t ordinary, std::size_t ood_count, double share) {
  const double wanted = share / (1 - share) * static_cast<double>(ordinary);
  const std::size_t count = std::min(ood_count, static_cast<std::size_t>(wanted));
  std::vector<std::size_t> which(count);
  for (std::size_t i = 0; i < count; ++i) which[i] = i * ood_count / count;
  return which;
}

void widen(std::array<float, 2 * kMeasurementCount>& quantiles, const Widening& by) {
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    for (const std::size_t end : {2 * m, 2 * m + 1}) quantiles[end] *= by[m];
}

IntervalModel calibrate_intervals(const std::vector<HeldOut>& rows) {
  IntervalModel model;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    double sum = 0;
    for (const HeldOut& row : rows) sum += error_of(row, m) * error_of(row, m);
    model.spread_floor[m] =
        static_cast<float>(std::max(std::sqrt(sum / static_cast<double>(rows.size())), kSpreadMin));
  }
  model.noise = fit_noise(model, rows);

  std::vector<const HeldOut*> all, even, odd;
  for (const HeldOut& row : rows) {
    all.push_back(&row);
    (row.subject % 2 == 0 ? even : odd).push_back(&row);
  }
  if (even.empty() || odd.empty()) even = odd = all;
  double best = 1e300;
  IntervalModel chosen = model;
  for (const IntervalKind kind : {IntervalKind::constant, IntervalKind::local_spread}) {
    IntervalModel trial = model;
    trial.kind = kind;
    double score = 0;
    for (const auto& [fitted, judged] : {std::pair(&even, &odd), std::pair(&odd, &even)}) {
      fit_quantiles(trial, *fitted);
      score += interval_score(trial, *judged);
      for (const HeldOut* row : *judged)
        for (std::size_t m = 0; m < kMeasurementCount; ++m) {
          const double e = error_of(*row, m) / width_of(trial, *row, m);
          if (e >= static_cast<double>(trial.quantiles[2 * m]) &&
              e <= static_cast<double>(trial.quantiles[2 * m + 1]))
            trial.coverage[m] += 1.0F / static_cast<float>(even.size() + odd.size());
        }
    }
    if (score < best) {
      best = score;
      chosen = trial;
    }
  }
  fit_quantiles(chosen, all);
  return chosen;
}

std::vector<float> calibrate_sex(const std::vector<HeldOut>& rows, double mean, double unit) {
  std::vector<LabelledScore> scores;
  scores.reserve(rows.size());
  for (const HeldOut& row : rows)
    scores.push_back({mean + unit * row.answer[kSexTarget], mean + unit * row.truth[kSexTarget] > 0});
  return calibrate_probability(scores);
}

std::vector<float> calibrate_probability(const std::vector<LabelledScore>& rows) {
  // Newton's method on the penalised log likelihood; the penalty (one pseudo-subject of slope 4) keeps separable
  // labels from an infinite slope.
  double a = 0;
  double b = 4;
  for (int round = 0; round < 30; ++round) {
    double ga = 0.01 * -a, gb = 0.1 * (4 - b), haa = 0.01, hab = 0, hbb = 0.1;
    for (const LabelledScore& row : rows) {
      const double x = row.score;
      const double p = 1 / (1 + std::exp(-std::clamp(a + b * x, -30.0, 30.0)));
      const double w = std::max(p * (1 - p), 1e-9);
      ga += (row.label ? 1.0 : 0.0) - p;
      gb += ((row.label ? 1.0 : 0.0) - p) * x;
      haa += w;
      hab += w * x;
      hbb += w * x * x;
    }
    const double determinant = haa * hbb - hab * hab;
    const double step_a = (hbb * ga - hab * gb) / determinant;
    const double step_b = (haa * gb - hab * ga) / determinant;
    a += std::clamp(step_a, -2.0, 2.0);
    b = std::max(b + std::clamp(step_b, -2.0, 2.0), 0.0);
    if (std::abs(step_a) + std::abs(step_b) < 1e-9) break;
  }
  std::vector<float> table(kScoreTableSize);
  for (std::size_t i = 0; i < kScoreTableSize; ++i) {
    const double x = (static_cast<double>(i) / (kScoreTableSize - 1) * 2 - 1) * kScoreMax;
    const double p = 1 / (1 + std::exp(-std::clamp(a + b * x, -30.0, 30.0)));
    table[i] = static_cast<float>(p);
    if (i > 0) table[i] = std::max(table[i], table[i - 1]);
  }
  return table;
}

}  // namespace im2fit::index
