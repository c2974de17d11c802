// SPDX-License-Identifier: Apache-2.0
// Outcomes of one condition as one table for people and one JSON for machines; every number is labelled synthetic.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/measurements/conditions.h"
#include "evaluation/measurements/error_statistics.h"
#include "evaluation/measurements/evaluation.h"

namespace im2fit::lab {

// Estimators that answer from the same frames, ours first.
enum class Estimator : int {
  ours,
  nearest,  // the nearest entry of our projection, before regression
  raw,      // the paper's answer: nearest neighbour of raw features
  paper,    // the paper's estimators: joint sums, one ellipse a girth
};
inline constexpr std::size_t kEstimatorCount = 4;
struct EstimatorName {
  std::string_view json, words;
};
inline constexpr std::array<EstimatorName, kEstimatorCount> kEstimators = {{{"ours", "ours"},
                                                                            {"projected_nearest", "nearest entry"},
                                                                            {"raw_nearest", "raw nearest neighbour"},
                                                                            {"paper", "paper's estimators"}}};

// Nominal coverages. Our interval states 95 %; the others take it for a normal distribution's, as the size does.
struct Level {
  double share, sds;
};
inline constexpr std::array<Level, 6> kLevels = {
    {{0.5, 0.67449}, {0.68, 0.99446}, {0.8, 1.28155}, {0.9, 1.64485}, {0.95, 1.95996}, {0.99, 2.57583}}};
inline constexpr std::size_t kStatedLevel = 4;

struct MeasurementReport {
  std::array<ErrorStatistics, kEstimatorCount> errors;  // count 0: that estimator does not answer it; of ours: no
                                                        // true value is known, and all but `repeatability` is zero
  std::array<double, kLevels.size()> covered{};         // share of truths inside, 0..1
  double interval_width = 0;                            // mean
  double interval_width_median = 0;
  Agreement agreement;
  Repeatability repeatability;  // pairs 0: shown once
  const ErrorStatistics& of(Estimator estimator) const { return errors[static_cast<std::size_t>(estimator)]; }
  double coverage() const { return covered[kStatedLevel]; }
  bool judged() const { return of(Estimator::ours).count > 0; }
};

// Some of the people, by their truth: a sex and a third of it by body mass index, or a family of a mixed run.
struct GroupReport {
  std::string name;  // "men, BMI to 24.3"
  int people = 0;
  double mass_index_low = 0, mass_index_high = 0;
  struct Row {
    int people = 0;                          // whose true value is known
    double bias = 0, mae = 0, coverage = 0;  // coverage: of the stated 95 % interval, 0..1
  };
  std::array<Row, kMeasurementCount> rows{};
};
// How an error grows with body mass index: 0 where the heavy err as the slim do.
struct IndexSlope {
  double slope = 0;           // mm (kg) a kg/m^2
  double standard_error = 0;  // of the slope
};

// Labels between the right size and the one answered: -1 one too small; the outer ones count all beyond.
inline constexpr int kSizeStepMost = 2;

// The models and the code behind a report: figures of other ones cannot be compared with it.
struct MeasuredWith {
  std::optional<std::uint64_t> dataset_version;  // of the samples in the index; nothing: the index does not name it
  std::uint32_t index_format = 0;                // index::kVersion
  std::size_t index_models = 0;                  // entries
  std::uint64_t seed = 0;                        // of people and rooms
  std::string commit;                            // as the caller gave it; empty: not given
};

struct Report {
  std::string condition, what, family;
  MeasuredWith with;
  int subjects = 0;
  int measured = 0;
  // Of the measured, by known fact (estimate/known_facts.h): people whose answer rests on it, or leaves it out.
  std::array<int, kKnownFactCount> facts_used{}, facts_doubted{};
  int lifted_arms = 0;                                     // of the measured: on guidance, before their measurement
  std::array<int, kGuidanceCount> not_measured_because{};  // subjects, by guidance seen
  std::array<MeasurementReport, kMeasurementCount> measurements;
  // Of those whose clothes are estimated: share estimated right by the frames alone, and the mean ease, mm.
  int clothing_estimated = 0;
  double clothing_right = 0, clothing_ease_mm = 0;
  double sex_accuracy = 0;  // shares of the measured, 0..1
  double raw_sex_accuracy = 0;
  double age_error_years = 0;  // mean absolute, of the median
  double age_coverage = 0;     // of the 95 % interval
  double age_band_accuracy = 0;
  double age_band_expected = 0;                         // expected by the likeliest groups' probabilities
  double size_accuracy = 0;                             // letter size by the default chart, outright
  double size_top_two = 0;                              // true size among the two most probable
  std::array<int, 2 * kSizeStepMost + 1> size_steps{};  // people, by labels off: too small first
  std::vector<GroupReport> groups;                      // sex by thirds of body mass index; then families, if several
  std::array<IndexSlope, kMeasurementCount> slopes{};
  double joint_error_mm = 0;  // mean over frames and joints
  double joints_within_100mm = 0;
  bool has_raw() const { return measurements[0].of(Estimator::raw).count > 0; }
  bool has_repeats() const { return measurements[0].repeatability.pairs > 0; }
};

// One condition, with the people behind its figures.
struct ConditionRun {
  Condition condition;
  std::vector<Outcome> outcomes;
  Report report;
};

Report report_of(const std::vector<Outcome>& outcomes, const std::string& condition, const std::string& what = "",
                 const std::string& family = "");
// Of the stated 95 %, over the measurements that are judged, 0..1.
double mean_coverage(const Report& report);
// Mean absolute error of chest, waist, hip and neck girth: which of two families is the worse.
double girth_error_mm(const Report& report);
// "noise", or "noise of ansur" where a family is named.
std::string title_of(const Report& report);
double value_of(const Outcome& outcome, Estimator estimator,
                std::size_t measurement);  // NaN where that estimator has none

std::string text_of(const Report& report);
// Several conditions side by side: mean absolute error by condition.
std::string text_of(const std::vector<ConditionRun>& runs);

// im2fit.evaluation/1
nlohmann::ordered_json json_value_of(const Report& report);
std::string json_of(const Report& report);
// A row a condition and measurement.
std::string csv_of(const std::vector<ConditionRun>& runs);
// A row a condition, person and measurement: what every figure is made of.
std::string people_csv_of(const std::vector<ConditionRun>& runs);

}  // namespace im2fit::lab
