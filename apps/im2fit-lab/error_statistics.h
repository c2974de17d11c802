// SPDX-License-Identifier: Apache-2.0
// What is said about a set of errors in every accuracy table.
#pragma once

#include <vector>

#include "kernels/core/measurement.h"

namespace im2fit::apps {

struct ErrorStatistics {
  int count = 0;
  double bias = 0;
  double mae = 0;  // mean absolute error
  double sd = 0;   // of the errors, n - 1
  double p95 = 0;  // of the absolute errors
  double max = 0;  // of the absolute errors
  // ISO 20685: mean +- 1.96 SD / sqrt(N) must lie within +-limit.
  double mean_low = 0;
  double mean_high = 0;
};
// Not finite values are left out; all zero for an empty set.
ErrorStatistics error_statistics(const std::vector<double>& errors);

// ISO 20685's maximum allowable error, mm: heights, small girths and breadths 4, segment lengths 5, large girths 9;
// 0 for what it does not cover.
double iso_20685_limit_mm(Measurement id);
bool within_iso_20685(const ErrorStatistics& statistics, Measurement id);

}  // namespace im2fit::apps
