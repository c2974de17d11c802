// SPDX-License-Identifier: Apache-2.0
// How a site's answers differ from its tape, by empirical Bayes: the effects that all measurements share (the
// camera's scale, how tight the tape is pulled) and those of each one, all drawn toward zero as far as these people
// do not support them. docs/calibration.md has the model and where its priors are from.
//
//   tape - answer = offset_m + sex_m (p_female - 1/2) + slope_m (answer - centre_m)
//                 + (scale * d_m + girth * g_m + camera_c * d_m) answer + noise
//
// d_m: 1 of lengths and girths, 3 of the weight; g_m: 1 of girths. Noise: normal, as the answer's own interval says
// times the width sought, correlated within a person as these people's residuals are; and the tape's own error.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "evaluation/study/site_person.h"

namespace im2fit::lab {

// Standard deviations, over sites, of the effects of a site. Found by the likelihood of these people; 0: no effect.
struct SiteSpreads {
  double offset = 0;  // in allowances of ISO 20685 (1 kg of the weight), as sex
  double sex = 0;
  double slope = 0;  // as a share, as all below
  double scale = 0;
  double girth = 0;
  double camera = 0;
};

struct SiteModel {
  struct Row {
    int people = 0;  // with a tape value; 0: nothing below is known
    double scale = 1, offset_men = 0, offset_women = 0;
    double width = 1;        // of the interval for a new person, including the correction's uncertainty
    double width_alone = 1;  // the same without any correction of the value
  };
  std::array<Row, kMeasurementCount> rows;
  struct Camera {
    std::string name;
    double scale = 1;
  };
  std::vector<Camera> cameras;  // two or more, else none
  SiteSpreads spreads;
};

// TEM of the tape of each measurement, from those taken twice; 0 where fewer than kTapePairsMin were.
inline constexpr int kTapePairsMin = 5;
std::array<double, kMeasurementCount> tape_errors(std::span<const SitePerson* const> people);

// Measurements with fewer than `people_min` tape values are left alone.
SiteModel fit_site_model(std::span<const SitePerson* const> people, int people_min);

// A person's answer corrected; `values`: false: the interval's width alone.
index::IntervalEstimate corrected(const SiteModel& model, const SitePerson& person, std::size_t m, bool values);

}  // namespace im2fit::lab
