// SPDX-License-Identifier: Apache-2.0
#include "person/tape_regression.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace im2fit {
namespace {

constexpr double kNormal95 = 1.959963984540054;  // half width of the 95 % interval, in standard deviations

struct TapeRegression {
  std::string_view id;
  bool woman;
  float residual;                               // standard deviation, as a share of the value
  std::array<float, kMeasurementCount> slopes;  // relative change for a relative change of each of the eleven
};
constexpr TapeRegression kRegressions[] = {
#include "person/tape_regression.inc"
};

// Of people whose bodies another maker made, fewer than 88 % had these inside (100 people of `eval --family ansur`,
// the small index, 2026-11-26: 76, 84 and 85 %); the residual is at least their error there, rms. Measured before
// their feet stood flat; with flat feet the errors are 0.108, 0.030 and 0.097. Test: tests/apps/tape_test.cpp.
struct OtherMake {
  std::string_view id;
  float residual;  // share of the value
};
constexpr OtherMake kOtherMakes[] = {{"ankle_height", 0.118F}, {"hip_height", 0.027F}, {"wrist_girth", 0.098F}};

double residual_of(const TapeRegression& regression) {
  float residual = regression.residual;
  for (const OtherMake& other : kOtherMakes)
    if (other.id == regression.id) residual = std::max(residual, other.residual);
  return static_cast<double>(residual);
}

const TapeRegression* regression_of(std::string_view id, bool woman) {
  for (const TapeRegression& regression : kRegressions)
    if (regression.id == id && regression.woman == woman) return &regression;
  return nullptr;
}

double relative_variance(const TapeRegression& regression, const index::Answer& answer) {
  double variance = residual_of(regression) * residual_of(regression);
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const index::IntervalEstimate& e = answer.measurements[i];
    if (!(e.value > 0)) continue;
    const double sd = static_cast<double>(e.high - e.low) / (2 * kNormal95 * static_cast<double>(e.value));
    const double share = static_cast<double>(regression.slopes[i]) * sd;
    variance += share * share;
  }
  return variance;
}

}  // namespace

std::vector<TapeInterval> tape_intervals(const body::Tape& tape, std::span<const float> values,
                                         const index::Answer& answer) {
  std::vector<TapeInterval> all(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const body::TapeDefinition& d = tape.definitions[i];
    if (d.kind == body::TapeKind::value) {
      const index::IntervalEstimate& e = answer.measurements[measurement_index(d.value)];
      all[i] = {true, e.low, e.high};
      continue;
    }
    const TapeRegression* regression = regression_of(d.id, answer.female >= 0.5F);
    if (regression == nullptr || !std::isfinite(values[i])) continue;
    const double half =
        kNormal95 * std::sqrt(relative_variance(*regression, answer)) * std::abs(static_cast<double>(values[i]));
    all[i] = {true, static_cast<float>(static_cast<double>(values[i]) - half),
              static_cast<float>(static_cast<double>(values[i]) + half)};
  }
  return all;
}

bool has_tape_regression(std::string_view id) {
  return regression_of(id, false) != nullptr && regression_of(id, true) != nullptr;
}

}  // namespace im2fit
