// SPDX-License-Identifier: Apache-2.0
// One level of the cascade: every tree finds a leaf, the leaves' vectors are added up (Kazemi & Sullivan 2014, eq.
// 1). A leaf is 32 coefficients of the level's own basis, a byte each: half a cache line instead of the two lines of
// 45 coordinates in 16 bits.
#pragma once

#include <cstdint>

#include "core/joints.h"
#include "kernels/tier.h"

namespace im2fit::joints {

inline constexpr int kSplitDepth = 5;
inline constexpr int kSplitCount = 31;  // inner nodes of a depth-5 tree
inline constexpr int kLeafCount = 32;
inline constexpr int kShapeSize = 3 * static_cast<int>(kJointCount);
static_assert(kShapeSize == 45);
inline constexpr int kLeafSize = 32;  // coefficients

struct Split {  // pixel a - pixel b > threshold goes right
  std::uint16_t a = 0;
  std::uint16_t b = 0;
  std::int16_t threshold = 0;
};
static_assert(sizeof(Split) == 6);

inline constexpr int kRunLanes = 8;  // runs side by side at most

// For each of `run_count` <= kRunLanes runs: sum[run * 32 + i] += the i-th coefficient of every tree's leaf. splits:
// 31 a tree, breadth first; leaves: 32 x 32 a tree; pixels: kRunLanes values a pixel, one of each run, within
// +-16383; those of runs beyond run_count are read and forgotten. Exact: up to 2^24 trees fit int32, whatever the
// leaves hold. Every split's a and b must be a pixel's place. No allocation, thread-safe.
using SumLeavesFunction = void(const Split* splits, const std::int8_t* leaves, int tree_count,
                               const std::int16_t* pixels, int run_count, std::int32_t* sum);
SumLeavesFunction sum_leaves_portable, sum_leaves_neon, sum_leaves_avx2, sum_leaves;

inline constexpr KernelVariant<SumLeavesFunction> kSumLeavesKernels[] = {
    IM2FIT_PORTABLE(sum_leaves) IM2FIT_NEON(sum_leaves) IM2FIT_AVX2(sum_leaves)};

}  // namespace im2fit::joints
