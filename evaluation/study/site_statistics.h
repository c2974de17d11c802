// SPDX-License-Identifier: Apache-2.0
// How a site's answers stand against its tape (docs/study.md): the paper's figures and ours, on these people.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "evaluation/measurements/error_statistics.h"
#include "evaluation/study/site_person.h"

namespace im2fit::lab {

// Of errors as they are, or with the tape's own error taken out: drawn to their mean until their variance is smaller
// by the tape's.
struct ErrorFigures {
  double sd = 0, mae = 0;
  double agreement_low = 0, agreement_high = 0;  // bias -+ 1.96 SD
  Share covered;                                 // of the 95 % intervals
};

struct MeasurementStudy {
  ErrorStatistics errors;  // answer less tape; count 0: no tape value
  ErrorFigures as_taken;
  Repeatability tape;         // of those taken twice
  bool tape_known = false;    // in enough pairs (kTapePairsMin) to be taken out, and smaller than the errors' spread
  ErrorFigures tape_out;      // when known
  double interval_width = 0;  // mean
  // Of the bias, against ISO 20685's allowance (0: it has none).
  double allowance_mm = 0;
  bool within = false;
  // So many people in all, and the 95 % interval of a bias and spread as these would lie within; 0: never, the bias
  // itself is too large; at least the number below.
  int people_for_claim = 0;
};
// ISO 20685-1 asks for a test of at least so many people.
inline constexpr int kIsoPeopleMin = 40;

struct StudyGroup {
  std::string name;  // "women", "men, lightest third", "close-fitting clothes"
  int people = 0;
  struct Row {
    int count = 0;
    double bias = 0, mae = 0;
    Share covered;
  };
  std::array<Row, kMeasurementCount> rows{};
};

struct SiteStudy {
  int visits = 0;  // of which each person's last counts
  int people = 0;
  std::array<MeasurementStudy, kMeasurementCount> measurements;
  std::vector<StudyGroup> groups;
  Share sex_right;   // of those whose sex is known
  Share size_right;  // of those whose worn size is on the chart
};

SiteStudy study_of(const std::vector<SitePerson>& visits);

// Answers and truths of people who differ in nothing but noise of this spread: what people_for_claim says.
int people_for_claim(double bias, double sd, double allowance);

}  // namespace im2fit::lab
