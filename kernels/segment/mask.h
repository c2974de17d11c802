// SPDX-License-Identifier: Apache-2.0
// From chosen cells to the full-resolution mask, and the feet grown back into the floor band.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/segment/grid.h"

namespace im2fit::segment {

// Sets `mask` to 255 where a pixel belongs to the cells with `chosen` != 0, else 0.
void refine_mask(const Grid& grid, DepthView depth, std::span<const std::uint8_t> chosen, MaskImage mask);

// Adds shoe and foot pixels between the mask's lower end and the floor. Floor height carries stature.
void grow_feet(const Grid& grid, DepthView depth, const FloorPlane& floor, MaskImage mask);

// Box, count, centroid and touched borders of the mask.
void describe_mask(const Grid& grid, DepthView depth, MaskView mask, Person& person);

}  // namespace im2fit::segment
