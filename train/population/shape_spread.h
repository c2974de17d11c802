// SPDX-License-Identifier: Apache-2.0
// How bodies of one sex, age, stature and mass differ in MakeHuman's local modifiers.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "core/rng.h"

namespace im2fit::body {

// Gaussian spread of one local modifier by family; 0: not used there. Means in both families offset MakeHuman's
// bias against ANSUR II at equal stature and mass (facts: too wide hips and waists).
struct ModifierSpread {
  std::string_view name;  // as in BodyModel::modifier_names()
  float training_sd;
  float held_out_sd;
  float man_mean = 0;
  float woman_mean = 0;
  bool paired = false;  // held_out draws left and right apart ("group/l-name", "group/r-name")
};
// Rows with training_sd 0 exist in held_out only and vice versa: shapes the index has never seen.
std::span<const ModifierSpread> modifier_spreads();

enum class SpreadUse { training, held_out };
// Values in BodyModel::modifier_names() order; names the model lacks are skipped, the draws stay the same.
std::vector<float> draw_modifiers(const body::BodyModel& model, SpreadUse use, bool woman, Rng& rng);

}  // namespace im2fit::body
