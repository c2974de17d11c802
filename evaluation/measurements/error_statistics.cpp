// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/error_statistics.h"

#include <algorithm>
#include <cmath>

namespace im2fit::lab {

ErrorStatistics error_statistics(const std::vector<double>& errors) {
  ErrorStatistics s;
  std::vector<double> magnitudes;
  for (const double e : errors) {
    if (!std::isfinite(e)) continue;
    magnitudes.push_back(std::abs(e));
    s.bias += e;
    s.mae += std::abs(e);
  }
  if (magnitudes.empty()) return s;
  s.count = static_cast<int>(magnitudes.size());
  const auto n = static_cast<double>(s.count);
  s.bias /= n;
  s.mae /= n;
  double squares = 0;
  for (const double e : errors)
    if (std::isfinite(e)) squares += (e - s.bias) * (e - s.bias);
  s.sd = s.count > 1 ? std::sqrt(squares / (n - 1)) : 0;
  std::sort(magnitudes.begin(), magnitudes.end());
  // Nearest rank: the smallest value that 95 % do not exceed.
  s.p95 = magnitudes[static_cast<std::size_t>(std::ceil(0.95 * n)) - 1];
  s.max = magnitudes.back();
  const double half = 1.96 * s.sd / std::sqrt(n);
  s.mean_low = s.bias - half;
  s.mean_high = s.bias + half;
  return s;
}

double iso_20685_limit_mm(Measurement id) {
  switch (id) {
    case Measurement::stature:
    case Measurement::inside_leg:
    case Measurement::neck_girth:
    case Measurement::shoulder_breadth:
      return 4;
    case Measurement::sleeve_length:
    case Measurement::leg_length:
      return 5;
    case Measurement::chest_girth:
    case Measurement::waist_girth:
    case Measurement::hip_girth:
    case Measurement::shoulder_girth:
      return 9;
    case Measurement::weight:
      break;
  }
  return 0;
}

bool within_iso_20685(const ErrorStatistics& statistics, Measurement id) {
  const double limit = iso_20685_limit_mm(id);
  return limit > 0 && statistics.count > 0 && statistics.mean_low >= -limit && statistics.mean_high <= limit;
}

Repeatability repeatability(const std::vector<std::array<double, 2>>& pairs) {
  Repeatability r;
  double sum = 0, squared_differences = 0;
  for (const auto& [a, b] : pairs) {
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    ++r.pairs;
    sum += a + b;
    squared_differences += (a - b) * (a - b);
  }
  if (r.pairs == 0) return r;
  const double values = 2.0 * r.pairs;
  const double mean = sum / values;
  r.tem = std::sqrt(squared_differences / values);
  if (mean > 0) r.percent = 100 * r.tem / mean;
  double squares = 0;
  for (const auto& [a, b] : pairs)
    if (std::isfinite(a) && std::isfinite(b)) squares += (a - mean) * (a - mean) + (b - mean) * (b - mean);
  if (squares > 0) r.reliability = 1 - r.tem * r.tem / (squares / (values - 1));
  return r;
}

Share share_of_count(int hits, int count) {
  Share share{hits, count};
  if (count <= 0) return share;
  constexpr double z = 1.96;
  const double n = count, p = hits / n;
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  share.value = p;
  share.low = std::max(0.0, centre - half);
  share.high = std::min(1.0, centre + half);
  return share;
}

Agreement agreement(const std::vector<std::array<double, 2>>& pairs) {
  std::vector<double> means, differences;
  for (const auto& [measured, truth] : pairs) {
    if (!std::isfinite(measured) || !std::isfinite(truth)) continue;
    means.push_back((measured + truth) / 2);
    differences.push_back(measured - truth);
  }
  const ErrorStatistics s = error_statistics(differences);
  Agreement a{s.count, s.bias, s.bias - 1.96 * s.sd, s.bias + 1.96 * s.sd, 0};
  if (means.empty()) return a;
  double centre = 0;
  for (const double m : means) centre += m / static_cast<double>(means.size());
  double up = 0, down = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    up += (means[i] - centre) * (differences[i] - s.bias);
    down += (means[i] - centre) * (means[i] - centre);
  }
  if (down > 0) a.slope = up / down;
  return a;
}

double quantile(const std::vector<double>& ascending, double share) {
  const double place = share * static_cast<double>(ascending.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, ascending.size() - 1);
  return ascending[below] + (place - static_cast<double>(below)) * (ascending[above] - ascending[below]);
}

BoxStatistics box_statistics(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  BoxStatistics box;
  if (values.empty()) return box;
  std::sort(values.begin(), values.end());
  box.count = static_cast<int>(values.size());
  box.quartile_1 = quantile(values, 0.25);
  box.median = quantile(values, 0.5);
  box.quartile_3 = quantile(values, 0.75);
  const double reach = 1.5 * (box.quartile_3 - box.quartile_1);
  box.low = box.quartile_1;
  box.high = box.quartile_3;
  for (const double v : values) {
    if (v < box.quartile_1 - reach || v > box.quartile_3 + reach) {
      box.outliers.push_back(v);
      continue;
    }
    box.low = std::min(box.low, v);
    box.high = std::max(box.high, v);
  }
  return box;
}

}  // namespace im2fit::lab
