// SPDX-License-Identifier: Apache-2.0
// Whether calibrations help people who had no part in them: from a pool of one site's people some are drawn and
// learned from, all others are judged, again and again.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "evaluation/study/site_person.h"

namespace im2fit::lab {

// Of one site and one number of people learned from, over the draws; biases and errors in the answer's own SDs, means
// over the measurements.
struct CalibrationTrial {
  std::string site;
  int people = 0, draws = 0;
  double bias_before = 0, bias_after = 0;
  double bias_off_median = 0, bias_off_least = 0;  // shares of a draw's bias that went
  double mae_before = 0, mae_after = 0;
  double mae_change_worst = 0;  // of a draw's, as a share of before; above 0: worse
  double coverage_before = 0, coverage_after = 0;
  double coverage_least = 0, coverage_most = 0;  // of a draw
  int values = 0, widths = 0;                    // draws with a calibration of values, of widths alone
};

CalibrationTrial try_calibrations(const std::string& site, const std::vector<SitePerson>& pool, int people, int draws,
                                  std::uint64_t seed);

// The same people before a site without bias: each measurement's mean error over all of them is taken off its tape.
std::vector<SitePerson> without_bias(std::vector<SitePerson> pool);

std::string text_of(const std::vector<CalibrationTrial>& trials);
std::string json_of(const std::vector<CalibrationTrial>& trials);

}  // namespace im2fit::lab
