// SPDX-License-Identifier: Apache-2.0
// Errors by who was measured: averages hide that the slim read too large and the heavy too small.
#pragma once

#include <vector>

#include "evaluation/measurements/report.h"

namespace im2fit::lab {

// Kilograms over square metres, of the truth; 0 without a stature.
double mass_index_of(const Outcome& outcome);

// Men then women, each in thirds of their number by body mass index, the lightest first; then each family where there
// are several. Empty groups are left out.
std::vector<GroupReport> groups_of(const std::vector<const Outcome*>& measured);

// Least squares of the error on body mass index over all people; zeros for fewer than three or where none differ.
IndexSlope index_slope(const std::vector<const Outcome*>& measured, std::size_t measurement);

}  // namespace im2fit::lab
