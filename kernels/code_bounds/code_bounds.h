// SPDX-License-Identifier: Apache-2.0
// The least distance of a place from anything inside each of many boxes: which leaves of a tree can be skipped.
#pragma once

#include <cstdint>

#include "kernels/code_distance/code_distance.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kBoxBlock = 16;  // boxes stored together

// `blocks` of 16 boxes: for each dimension sixteen low edges, then sixteen high edges, low <= high. Edges and place
// within +-kCodePlaceMax; at most kCodeDimensionMax dimensions. out, for each box: the sum over the dimensions of
// min(gap, kCodeGapMax)^2, where gap is the way from the place to the box along that dimension, 0 inside: never above
// what code_distance gives for a point of the box. Exact integers. No allocation, thread-safe.
using CodeBoundsFunction = void(const std::int16_t* blocks, int block_count, const std::int16_t* place,
                                int dimension_count, std::int32_t* out);
CodeBoundsFunction code_bounds_portable, code_bounds_neon, code_bounds_avx2, code_bounds;

inline constexpr KernelVariant<CodeBoundsFunction> kCodeBoundsKernels[] = {
    IM2FIT_PORTABLE(code_bounds) IM2FIT_NEON(code_bounds) IM2FIT_AVX2(code_bounds)};

}  // namespace im2fit
