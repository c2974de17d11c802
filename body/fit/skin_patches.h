// SPDX-License-Identifier: Apache-2.0
// Patches of the skin, about equally large: the residual of a fit is reported patch by patch. The same for a space on
// every machine: + - * and comparisons in written order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "body/shape_space.h"

namespace im2fit::body {

inline constexpr std::size_t kPatchMax = 160;

inline std::size_t patch_count(const ShapeSpace& space) {
  return std::min(kPatchMax, space.point_count);
}

// The patch of each of the space's points: of patch_count() points that each lie farthest from those before them
// (Gonzalez 1985), the nearest one in the mean body.
std::vector<std::uint16_t> skin_patches(const ShapeSpace& space);

}  // namespace im2fit::body
