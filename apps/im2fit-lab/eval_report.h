// SPDX-License-Identifier: Apache-2.0
// Outcomes as one table for people and one JSON for machines; every number is labelled synthetic.
#pragma once

#include <string>
#include <vector>

#include "apps/im2fit-lab/error_statistics.h"
#include "apps/im2fit-lab/evaluation.h"

namespace im2fit::apps {

struct MeasurementReport {
  ErrorStatistics ours;
  ErrorStatistics paper;    // count 0: the paper does not measure it
  ErrorStatistics raw;      // nearest neighbour of raw features
  ErrorStatistics nearest;  // nearest entry in the projected space
  double coverage = 0;      // share of truths inside the 95 % interval, 0..1
};

struct Report {
  std::string condition;
  int subjects = 0;
  int measured = 0;
  std::array<int, kGuidanceCount> not_measured_because{};  // subjects, by guidance seen
  std::array<MeasurementReport, kMeasurementCount> measurements;
  double sex_accuracy = 0;  // shares of the measured, 0..1
  double raw_sex_accuracy = 0;
  double size_accuracy = 0;   // letter size by the default chart, outright
  double size_top_two = 0;    // true size among the two most probable
  double joint_error_mm = 0;  // mean over frames and joints
  double joints_within_100mm = 0;
};

Report report_of(const std::vector<Outcome>& outcomes, const std::string& condition);
std::string text_of(const Report& report);
std::string json_of(const Report& report);

}  // namespace im2fit::apps
