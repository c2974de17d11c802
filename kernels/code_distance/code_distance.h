// SPDX-License-Identifier: Apache-2.0
// Squared distances from a place to points stored as int8 codes: a code c of dimension j stands at c * step[j] on a
// grid that all dimensions share.
#pragma once

#include <array>
#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kCodeDimensionMax = 16;
inline constexpr int kCodeBlock = 16;  // points stored together
inline constexpr std::int32_t kCodeStepMax = 127;
// Bound of a place's coordinates. A code reaches 128 * 127 = 16256 too, so that a gap fits 16 bits.
inline constexpr std::int32_t kCodePlaceMax = 16256;
// Gaps longer than this count as this long: their squares over 16 dimensions add up to less than 2^31. Neighbours are
// far nearer; among points this far away the order is of no use.
inline constexpr std::int32_t kCodeGapMax = 11585;

// The query, prepared; coordinates beyond kCodePlaceMax are clamped.
struct CodeQuery {
  // Steps 0..kCodeStepMax; at most kCodeDimensionMax dimensions.
  CodeQuery(const std::int32_t* steps, const std::int32_t* place, int dimension_count);
  std::array<std::int16_t, kCodeDimensionMax> step{}, place{};
  int pair_count = 0;  // dimensions, two and two
};

// `blocks` of 16 points: for each pair of dimensions the codes of point 0 (two bytes), of point 1, ... (32 bytes).
// out, for each point: the sum over the dimensions of min(|code * step - place|, kCodeGapMax)^2. Dimensions of step 0
// and place 0 may be left out. least, for each block: the
// smallest of its sixteen. Exact integers. No allocation, thread-safe.
using CodeDistanceFunction = void(const std::int8_t* blocks, int block_count, const CodeQuery& query,
                                  std::int32_t* out, std::int32_t* least);
CodeDistanceFunction code_distance_portable, code_distance_neon, code_distance_avx2, code_distance;

inline constexpr KernelVariant<CodeDistanceFunction> kCodeDistanceKernels[] = {
    IM2FIT_PORTABLE(code_distance) IM2FIT_NEON(code_distance) IM2FIT_AVX2(code_distance)};

}  // namespace im2fit
