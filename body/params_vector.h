// SPDX-License-Identifier: Apache-2.0
// Params as a row of numbers and back: how an index stores the bodies it lends.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "body/model.h"

namespace im2fit::body {

inline constexpr std::size_t kMacroCount = 11;  // before the local modifiers

// kMacroCount + modifier_count values: gender, age_years, muscle, weight, height, proportions, cup, firmness, race,
// then the modifiers, missing ones zero.
inline std::vector<float> params_to_vector(const Params& p, std::size_t modifier_count) {
  std::vector<float> out = {p.gender, p.age_years, p.muscle,  p.weight,  p.height, p.proportions,
                            p.cup,    p.firmness,  p.race[0], p.race[1], p.race[2]};
  out.resize(kMacroCount + modifier_count, 0.0F);
  std::copy_n(p.modifiers.begin(), std::min(modifier_count, p.modifiers.size()), out.begin() + kMacroCount);
  return out;
}

// The inverse; values are clamped to the sliders' ranges and races scaled to sum to 1, so that a rounded row is a
// valid body. Rows shorter than kMacroCount give the defaults.
inline Params params_from_vector(std::span<const float> row) {
  Params p;
  if (row.size() < kMacroCount) return p;
  const auto slider = [&](std::size_t i) { return std::clamp(row[i], 0.0F, 1.0F); };
  p.gender = slider(0);
  p.age_years = std::clamp(row[1], 18.0F, 90.0F);
  p.muscle = slider(2);
  p.weight = slider(3);
  p.height = slider(4);
  p.proportions = slider(5);
  p.cup = slider(6);
  p.firmness = slider(7);
  const float sum = slider(8) + slider(9) + slider(10);
  if (sum > 0) p.race = {slider(8) / sum, slider(9) / sum, slider(10) / sum};
  for (std::size_t i = kMacroCount; i < row.size(); ++i) p.modifiers.push_back(std::clamp(row[i], -1.0F, 1.0F));
  return p;
}

}  // namespace im2fit::body
