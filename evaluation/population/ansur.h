// SPDX-License-Identifier: Apache-2.0
// ANSUR II, the US Army's survey of 2012: 4082 men and 1986 women measured by hand; public domain.
#pragma once

#include <cstddef>
#include <cstdint>
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

// The survey is split in two: one part may teach (densities and regressions that training people are drawn from), the
// other only judges (the evaluation's family `ansur`). Decided by the row alone, so that neither side depends on what
// the other reads or in which order.
// `row`: 0-based place in what read_ansur_columns() returns for that sex. True: only the evaluation may use it.
constexpr bool held_out_row(bool woman, std::size_t row) {
  std::uint64_t z = (static_cast<std::uint64_t>(row) * 2 + (woman ? 1 : 0)) * 0x9E3779B97F4A7C15ULL + 0xA45A;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;  // SplitMix64's finaliser: neighbours in the file are unrelated
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return ((z ^ (z >> 31)) & 1) != 0;
}

}  // namespace im2fit::lab
