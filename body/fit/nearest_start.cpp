// SPDX-License-Identifier: Apache-2.0
#include "body/fit/nearest_start.h"

#include <cmath>

#include "body/fit/measurement_fit.h"
#include "core/cholesky.h"

namespace im2fit::body {
namespace {

constexpr double kRelativeError = 0.01;
constexpr double kPivotMin = 1e-12;

}  // namespace

MeasurementDistance::MeasurementDistance(bool woman) {
  const MeasurementRegression& regression = measurement_regression(woman);
  std::array<FitParameters, kMeasurementCount> slopes{};  // of the measurements by whitened unknowns
  std::size_t next = 0;
  for (std::size_t i = 0; i < kFitParameterCount; ++i)
    for (std::size_t j = 0; j <= i; ++j, ++next)
      for (std::size_t r = 0; r < kMeasurementCount; ++r)
        slopes[r][j] += static_cast<double>(regression.slopes[r][i]) * static_cast<double>(regression.spread[next]);
  for (std::size_t r = 0; r < kMeasurementCount; ++r)
    for (std::size_t c = 0; c <= r; ++c) {
      double sum = r == c ? kRelativeError * kRelativeError : 0;
      for (std::size_t j = 0; j < kFitParameterCount; ++j) sum += slopes[r][j] * slopes[c][j];
      factor_[r][c] = sum;
    }
  cholesky_factor(factor_, kMeasurementCount, kPivotMin);
}

double MeasurementDistance::squared(const MeasurementValues& a, const MeasurementValues& b) const {
  Rows x{};
  double sum = 0;
  for (std::size_t r = 0; r < kMeasurementCount; ++r) {
    const double more = static_cast<double>(b[r]) - static_cast<double>(a[r]);
    const double mean = 0.5 * (static_cast<double>(b[r]) + static_cast<double>(a[r]));
    x[r] = std::isfinite(more) && mean > 0 ? more / mean : 0;
    for (std::size_t c = 0; c < r; ++c) x[r] -= factor_[r][c] * x[c];
    x[r] /= factor_[r][r];
    sum += x[r] * x[r];
  }
  return sum;
}

std::size_t nearest_start(const StartBodies& starts, bool woman, const MeasurementValues& to) {
  const MeasurementDistance distance(woman);
  const std::size_t end = woman ? starts.size() : starts.man_count;
  std::size_t best = woman ? starts.man_count : 0;
  double least = distance.squared(starts.measured[best], to);
  for (std::size_t i = best + 1; i < end; ++i)
    if (const double d = distance.squared(starts.measured[i], to); d < least) {
      least = d;
      best = i;
    }
  return best;
}

}  // namespace im2fit::body
