// SPDX-License-Identifier: Apache-2.0
// Squared distances from a place to points stored as int8 codes: a code c of dimension j stands at c * step[j].
#pragma once

#include <array>
#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kCodeDimensionMax = 16;
inline constexpr int kCodeBlock = 16;  // points stored together
inline constexpr std::int32_t kCodeStepMax = 1024;
// Bound of a place's coordinates. The largest code reaches 128 * 1024 = 2^17, so a squared distance stays below
// 16 * (2^20 + 2^17)^2 < 2^45.
inline constexpr std::int32_t kCodePlaceMax = (1 << 20) - 1;

// What is asked for, prepared: |c s - p|^2 = |c s|^2 - 2 sum c (s p) + |p|^2 (each j), with the weight s p in two
// halves of 16 bits: s p = 2^15 high + low, |s p| < 2^30.
struct CodeQuery {
  CodeQuery(const std::int32_t* steps, const std::int32_t* place, int dimension_count);
  std::array<std::int32_t, kCodeDimensionMax> step{}, place{};
  std::array<std::int16_t, 2 * kCodeDimensionMax> weight{};  // per pair of dimensions: two highs, two lows
  std::int64_t square = 0;                                   // |p|^2
  int pair_count = 0;                                        // dimensions, two and two
};

// `blocks` of 16 points: for each pair of dimensions the codes of point 0 (two bytes), of point 1, ... (32 bytes).
// norm: |c s|^2 of each point. out: a squared distance for each point, exact. Dimensions of step 0 may be left out.
// No allocation, thread-safe.
using CodeDistanceFunction = void(const std::int8_t* blocks, const std::int64_t* norm, int block_count,
                                  const CodeQuery& query, std::int64_t* out);
CodeDistanceFunction code_distance_ref, code_distance_portable, code_distance_neon, code_distance_avx2, code_distance;

inline constexpr KernelVariant<CodeDistanceFunction> kCodeDistanceKernels[] = {
#include "kernels/code_distance/kernels.inc"
};

}  // namespace im2fit
