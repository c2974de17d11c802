// SPDX-License-Identifier: Apache-2.0
// Which start body (body/start_bodies.h) a fit to measurements begins from.
#pragma once

#include <array>
#include <cstddef>

#include "body/start_bodies.h"
#include "core/measurement.h"

namespace im2fit::body {

// The distance of two bodies of one sex by their measurements: the length of the shortest change, in standard
// deviations of people, that turns one set of measurements into the other by the mean slopes of that sex
// (MeasurementRegression). Relative differences d give sqrt(d' (G G' + 1e-4 I)^-1 d), G: slopes times the people's
// factor; the identity stands for an error of 1 % in each measurement. + - * / and sqrt only.
class MeasurementDistance {
 public:
  explicit MeasurementDistance(bool woman);
  // A measurement that is not finite in either set does not count.
  double squared(const MeasurementValues& a, const MeasurementValues& b) const;

 private:
  using Rows = std::array<double, kMeasurementCount>;
  std::array<Rows, kMeasurementCount> factor_{};  // Cholesky
};

// The start body of this sex with the least MeasurementDistance; of equals the first. `starts` has some of each sex.
std::size_t nearest_start(const StartBodies& starts, bool woman, const MeasurementValues& to);

}  // namespace im2fit::body
