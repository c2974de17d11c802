// SPDX-License-Identifier: Apache-2.0
// Statistics of a set of errors, the same in every accuracy table.
#pragma once

#include <array>
#include <vector>

#include "core/measurement.h"

namespace im2fit::lab {

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
// 0 for a measurement that it does not cover.
double iso_20685_limit_mm(Measurement id);
bool within_iso_20685(const ErrorStatistics& statistics, Measurement id);

// The same people measured twice.
struct Repeatability {
  int pairs = 0;
  double tem = 0;          // technical error of measurement: sqrt(sum of squared differences / 2n)
  double percent = 0;      // of the mean
  double reliability = 0;  // 1 - TEM^2 / SD^2, SD of all 2n values; 0.95 is good
};
// Pairs with a value that is not finite are left out.
Repeatability repeatability(const std::vector<std::array<double, 2>>& pairs);

// A share of so many, with its 95 % interval (Wilson 1927), which is never outside 0..1.
struct Share {
  int hits = 0, count = 0;
  double value = 0, low = 0, high = 1;
};
Share share_of_count(int hits, int count);

// Bland and Altman 1986: the difference of two methods against their mean.
struct Agreement {
  int count = 0;
  double bias = 0;           // of first less second
  double low = 0, high = 0;  // limits of agreement: bias +- 1.96 SD
  double slope = 0;          // of the difference by the mean: not zero where large people err otherwise
};
// Pairs of {measured, true}. Not finite ones are left out.
Agreement agreement(const std::vector<std::array<double, 2>>& pairs);

// Tukey's box: quartiles, whiskers at the farthest values within 1.5 times the quartiles' distance, the rest.
struct BoxStatistics {
  int count = 0;
  double low = 0, quartile_1 = 0, median = 0, quartile_3 = 0, high = 0;
  std::vector<double> outliers;  // ascending
};
BoxStatistics box_statistics(std::vector<double> values);

// Between the two nearest ranks (Hyndman and Fan's type 7). `ascending` is not empty; `share` 0..1.
double quantile(const std::vector<double>& ascending, double share);

}  // namespace im2fit::lab
