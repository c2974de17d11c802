// SPDX-License-Identifier: Apache-2.0
// The normal equations of a plane in inverse depth, q . (x/z, y/z, 1) = -1/z, over the pixels near a known one.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

// Upper triangle of the 3x3 normal matrix (xx xy x yy y 1), right side (x y 1), and the sum of weights.
struct PlaneSums {
  double a[6] = {};
  double b[3] = {};
  double weight = 0;
};

// Which pixels of a cell count: every `stride`-th of every `stride`-th row, 1 or 2.
struct FloorCell {
  std::uint16_t u, v;  // px, upper left
  std::uint16_t stride;
  float weight;
};

struct FloorGate {
  float up_x;              // the known plane's
  float camera_height_mm;  // height of p is (up_x x/z + row_up) z + camera_height
  float flat_mm, noise;    // a pixel counts within flat + noise z of height 0
  const float* ray_x;      // x/z per pixel column
  const float* ray_y;      // y/z per pixel row
  const float* row_up;     // up_y y/z + up_z per pixel row
};

// Adds up the pixels with data (1..10000 mm) inside the gate, `count` cells of step x step pixels. Float, in this
// order: the pixels of a row of a cell from left to right into sums of 1, x/z, its square, 1/z and their product;
// then each row, as doubles, times weight, y/z and its square into the equations, cell by cell. No allocation,
// thread-safe. Portable is within 1e-5 of ref in each sum, relative to the sum of magnitudes: four float additions.
// Every tier gives portable's bits; ARMv7's NEON cannot divide and has no doubles, so portable runs there.
using FloorSumsFunction = void(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count,
                               PlaneSums& out);
FloorSumsFunction floor_sums_portable, floor_sums_neon, floor_sums_avx2;
FloorSumsFunction floor_sums;  // the fastest here

using FloorSumsKernel = KernelVariant<FloorSumsFunction>;
inline constexpr FloorSumsKernel kFloorSumsKernels[] = {IM2FIT_PORTABLE(floor_sums) IM2FIT_NEON64(floor_sums)
                                                            IM2FIT_AVX2(floor_sums)};

}  // namespace im2fit
