// SPDX-License-Identifier: Apache-2.0
// From a site's people to its calibration, or to the reason for a refusal: judged on people left out of all learning,
// one at a time (docs/calibration.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estimate/site_calibration.h"
#include "evaluation/study/site_model.h"
#include "evaluation/study/site_person.h"

namespace im2fit::lab {

// Fewer say too little of anything: the bias of 10 people is known to a third of their spread.
inline constexpr int kCalibrationPeopleMin = 10;
// A tape value whose error, in the answer's own SDs, lies farther from the median than so many robust SDs (1.4826
// MAD) is taken for a slip of the pen and left out: of 1,000 normal values none lies there.
inline constexpr double kSlipSds = 6;

// Of one measurement: people left out of the learning, as answered and corrected.
struct LeftOut {
  int people = 0;
  double bias_before = 0, bias_after = 0;
  double mae_before = 0, mae_after = 0;
  double coverage_before = 0, coverage_after = 0;  // shares, 0..1
};

struct CalibrationOutcome {
  int people = 0;
  std::vector<std::string> left_aside;  // "p07: waist_girth 123.0, answered 823.1": slips of the pen
  SiteModel model;
  bool values = false;                            // values are corrected; false: widths alone, unless refused
  std::array<LeftOut, kMeasurementCount> rows{};  // with the corrections of this calibration
  // Mean over people of how much smaller the mean |error| is, in the answer's own SDs, and its standard error.
  double gain = 0, gain_se = 0;
  double coverage_before = 0, coverage_after = 0;  // over all values
  std::string refusal;                             // "": there is a calibration
};

// One visit a person: of several visits the last one counts. Depends on nothing but `people`.
CalibrationOutcome calibrate(const std::vector<SitePerson>& people);

// What a device reads. `outcome` has no refusal.
SiteCalibration site_calibration(const CalibrationOutcome& outcome, const std::string& name,
                                 std::uint32_t index_crc32c);

// For people: the findings, left-out errors beside them, and the refusal.
std::string text_of(const CalibrationOutcome& outcome);
// im2fit.calibration/1
std::string json_of(const CalibrationOutcome& outcome);

// The last visit of each person, in the order of `people`.
std::vector<SitePerson> one_visit_each(const std::vector<SitePerson>& people);

}  // namespace im2fit::lab
