// SPDX-License-Identifier: Apache-2.0
// The two innermost loops of a fit, which are most of its time. The same bits in every variant: each value is its own
// sum in written order, so the width of a vector changes none.
#pragma once

#include <cstddef>

#include "kernels/tier.h"

namespace im2fit::body {

inline constexpr std::size_t kRowGroup = 8;

// Eight weighted equations: rows `stride` floats apart, `width` slopes in each.
struct RowGroup {
  const float* rows;
  std::size_t stride, width;
  const float* weight;    // eight
  const float* residual;  // eight
};
// Of matrices that move a point: `parts` of three rows of `count` slopes each, and the direction asked for in each
// part.
inline constexpr std::size_t kPartsMax = 5;
struct SlopeParts {
  const float* rows[kPartsMax];
  float along[kPartsMax][3];
  std::size_t parts, count;
};

// sum_rows: sums[i stride + c] += the rows' weight x slope i x slope c for c >= i, pairwise in float32; right[c] +=
// weight x residual x slope c, row by row in float64.
// add_slopes: out[k] = the sum over parts of along . (three slopes k), part by part.
struct FitLoops {
  void (*sum_rows)(const RowGroup& group, float* sums, double* right);
  void (*add_slopes)(const SlopeParts& parts, float* out);
};
extern const FitLoops kFitLoopsPortable;
extern const FitLoops kFitLoopsAvx2;  // where IM2FIT_HAVE_AVX2
const FitLoops& fit_loops();          // the fastest that runs here

}  // namespace im2fit::body
