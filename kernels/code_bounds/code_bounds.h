// SPDX-License-Identifier: Apache-2.0
// How near a place can be to anything inside each of many boxes: which leaves of a tree need not be looked at.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kBoxBlock = 8;         // boxes stored together
inline constexpr int kBoundUnitBits = 8;    // a bound of 1 stands for a squared distance of 2^8
inline constexpr int kBoundGapMax = 11585;  // squared and added up over 16 dimensions: below 2^31

// `blocks` of 8 boxes: for each dimension eight low edges, then eight high edges. Edges and place within +-2^21, low
// <= high; at most 16 dimensions. out, for each box: the sum over the dimensions of min(gap >> 4, 11585)^2, where gap
// is the way from the place to the box along that dimension, 0 inside. Rounded down everywhere: out * 2^8 is never
// above the squared distance to any point of the box. Exact integers. No allocation, thread-safe.
using CodeBoundsFunction = void(const std::int32_t* blocks, int block_count, const std::int32_t* place,
                                int dimension_count, std::uint32_t* out);
CodeBoundsFunction code_bounds_ref, code_bounds_portable, code_bounds_neon, code_bounds_avx2, code_bounds;

inline constexpr KernelVariant<CodeBoundsFunction> kCodeBoundsKernels[] = {
#include "kernels/code_bounds/kernels.inc"
};

}  // namespace im2fit
