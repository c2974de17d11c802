// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/error_statistics.h"

#include <algorithm>
#include <cmath>

namespace im2fit::apps {

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

}  // namespace im2fit::apps
