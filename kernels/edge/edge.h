// SPDX-License-Identifier: Apache-2.0
// Pixels at a jump in depth and those that stand alone: where structured light and time of flight invent depths
// between two surfaces ("flying pixels").
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

// Sets `mask` (of depth's size) to 255 where a pixel with data has one above, below, left or right whose depth
// differs by more than the limit, or has none within the limit among its eight neighbours; 0 elsewhere. Without data
// is 0, and so is outside the picture. The limit is 40 mm + 1.5 disparity steps of 2.85e-6 z z, in whole numbers 40 +
// ((z z >> 16) * 18361 >> 16): up to 1.3 mm less than the real one. No allocation, thread-safe. Integers only: all
// tiers agree bit for bit.
using EdgeFunction = void(DepthView depth, MaskImage mask);
EdgeFunction edge_ref, edge_portable, edge_neon, edge_avx2;
EdgeFunction edge;  // the fastest here

using EdgeKernel = KernelVariant<EdgeFunction>;
inline constexpr EdgeKernel kEdgeKernels[] = {
#include "kernels/edge/kernels.inc"
};

}  // namespace im2fit
