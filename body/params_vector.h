// SPDX-License-Identifier: Apache-2.0
// body::Params as the row of floats a dataset sample stores:
//   gender, age_years, muscle, weight, height, proportions, cup, firmness, race[3], then one value per local modifier
//   in BodyModel::modifier_names() order, then the warp's values (body/warp.h).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "body/model.h"
#include "body/warp.h"

namespace im2fit::body {

inline constexpr std::size_t kMacroParamCount = 11;
inline constexpr std::size_t kAgeParam = 1;  // years

constexpr std::size_t params_vector_size(std::size_t modifier_count) {
  return kMacroParamCount + modifier_count + kWarpCount;
}

// Modifiers missing in `params` are zeros, those beyond `modifier_count` are left out.
std::vector<float> pack_params(const Params& params, std::size_t modifier_count);
// The parameters of a whole row.
Params unpack_params(std::span<const float> row);

}  // namespace im2fit::body
