// SPDX-License-Identifier: Apache-2.0
// A person's age, estimated from the ages of similar people in the index.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "index/index.h"

namespace im2fit {

// The paper's age groups (its Table 1), whose adults the population has.
inline constexpr std::size_t kAgeBandCount = 4;
inline constexpr std::array<std::string_view, kAgeBandCount> kAgeBandNames = {"18-25", "25-45", "45-65", "65-75"};

std::size_t age_band_of(float years);  // those younger and older than the groups belong to the first and last

struct AgeAnswer {
  index::IntervalEstimate years;             // the median of similar people, and the interval of 95 % of them
  std::array<float, kAgeBandCount> bands{};  // probabilities; they sum to 1
};

// `ages`: years, in any order, which changes. Empty: everything is 0.
AgeAnswer age_among(std::span<float> ages);

}  // namespace im2fit
