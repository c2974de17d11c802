// SPDX-License-Identifier: Apache-2.0
// ANSUR II, the US Army's survey of 2012: 4082 men and 1986 women measured by hand; public domain.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace im2fit::lab {

// Columns of ANSUR_II_FEMALE_Public.csv or ANSUR_II_MALE_Public.csv in `folder`: a row a person, values in the order
// of `columns`, in the file's own units (mm, 0.1 kg). Names of columns are matched whatever their case. Errors name
// the file, person and column; fewer than 100 people are one.
Result<std::vector<std::vector<double>>> read_ansur_columns(const std::string& folder, bool woman,
                                                            std::span<const std::string_view> columns);

}  // namespace im2fit::lab
