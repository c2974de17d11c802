// SPDX-License-Identifier: Apache-2.0
// The data of one visit to a site: a person's tape values beside the answers. From sessions
// (apps/im2fit-lab/site_people.h) or from simulated people.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "core/measurement.h"
#include "index/index.h"

namespace im2fit::lab {

inline constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// mm, kg for the weight. NaN: not taken.
struct TapeReadings {
  double first = kNoValue, second = kNoValue;
  bool taken() const { return std::isfinite(first); }
  bool twice() const { return taken() && std::isfinite(second); }
  double mean() const { return twice() ? (first + second) / 2 : first; }
};

inline bool is_girth(std::size_t m) {
  return kMeasurementTable[m].id.ends_with("girth");
}
inline bool holds(const index::IntervalEstimate& e, double truth) {
  return truth >= static_cast<double>(e.low) && truth <= static_cast<double>(e.high);
}
// SD of the error that an answer states: 95 % of a normal distribution lie within 1.96.
inline double answer_sd(const index::IntervalEstimate& e) {
  return std::max(1e-3, static_cast<double>(e.high - e.low) / (2 * 1.96));
}

struct SitePerson {
  std::string person;  // a pseudonym: the same for the same person
  std::optional<bool> woman;
  std::string clothing;  // "bare", "close", "loose", "" unknown
  std::string camera;    // hal::SourceInfo::name
  std::string worn_size, answered_size;
  std::array<TapeReadings, kMeasurementCount> tape{};
  std::array<index::IntervalEstimate, kMeasurementCount> answer{};  // before any site calibration
  double female = 0.5;                                              // answered probability

  double error(std::size_t m) const { return static_cast<double>(answer[m].value) - tape[m].mean(); }  // NaN: no tape
  // kg/m^2 from the tape and the scale; NaN without both.
  double mass_index() const {
    const double metres = tape[measurement_index(Measurement::stature)].mean() / 1000;
    return tape[measurement_index(Measurement::weight)].mean() / (metres * metres);
  }
};

}  // namespace im2fit::lab
