// SPDX-License-Identifier: Apache-2.0
// A metric grid of the fused person for the device descriptor: blocks of k x k pixels, k = the whole number that
// brings the grid nearest to kGridSpacingMm at the person's distance. Averaging a block takes out the sensor's noise
// and makes the pair count independent of resolution and distance.
#pragma once

#include <cstdint>
#include <span>

#include "core/camera.h"

namespace im2fit {

inline constexpr float kGridSpacingMm = 20.0F;

int grid_step_px(const Intrinsics& intrinsics, float distance_mm);

// Intrinsics of the grid of step k: its pixel (i, j) is the centre of block (i, j).
Intrinsics grid_intrinsics(const Intrinsics& intrinsics, int step_px);

// x, y, z: grid width*height values, NaN where a block has too little. depth_q4 in 1/16 mm.
void decimate(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& grid, int step_px,
              std::span<float> x, std::span<float> y, std::span<float> z);

}  // namespace im2fit
