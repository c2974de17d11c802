// SPDX-License-Identifier: Apache-2.0
// A garment coloured by how it sits.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "garment/drape/outfit.h"

namespace im2fit {

// A linear colour a vertex of the garment: red where cloth is stretched by kEaseMapTightStrain or more, green where
// it lies on the body unstretched, blue where it stands kEaseMapLooseMm or more off the skin.
inline constexpr float kEaseMapTightStrain = 0.08F;  // jersey is cut to be worn at less
inline constexpr float kEaseMapLooseMm = 40;
std::vector<std::array<float, 3>> ease_map(const body::Outfit& outfit, std::size_t index);

}  // namespace im2fit
