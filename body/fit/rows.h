// SPDX-License-Identifier: Apache-2.0
// The innermost loops of a fit, which are most of its time. The same bits in every variant: each value is its own
// sum in written order, so the width of a vector changes none.
#pragma once

#include <cstddef>

#include "kernels/tier.h"

namespace im2fit::body {

// Three coordinates and a fourth of no meaning, or any four numbers.
using Four = float __attribute__((vector_size(4 * sizeof(float))));

inline constexpr std::size_t kRowGroup = 8;
inline constexpr std::size_t kRowLanes = 8;  // columns done together
inline constexpr std::size_t whole_lanes(std::size_t columns) {
  return (columns + kRowLanes - 1) / kRowLanes * kRowLanes;
}

// Eight weighted equations: rows `stride` >= whole_lanes(width) floats apart, `width` slopes in each, then any
// numbers.
struct RowGroup {
  const float* rows;
  std::size_t stride, width;
  const float* weight;    // eight
  const float* residual;  // eight
};
// Of matrices that move a point: `parts` of three rows of `count` slopes each, and the direction wanted in each
// part.
inline constexpr std::size_t kPartsMax = 5;
struct SlopeParts {
  const float* rows[kPartsMax];
  float along[kPartsMax][3];
  std::size_t parts, count;
};

// Values of a shape, each its mean and a row of the basis times the coefficients.
struct ShapeRows {
  const float *mean, *basis, *coefficients;
  std::size_t value_count, shape_count;
};

// A row of a factor and finished ones above it.
struct PivotRows {
  double* matrix;
  std::size_t stride, row;
  std::size_t pivot_first, pivot_end;  // rows
  std::size_t column_first, column_end;
};

// sum_rows: sums[i stride + c] += the rows' weight x slope i x slope c for width > c >= i, pairwise in float32, and
// numbers of no meaning where c has whole_lanes() with one of these; right[c] += weight x residual x slope c, row by
// row in float64.
// add_slopes: out[k] = the sum over parts of along . (three slopes k), part by part.
// add_shapes: out[i] = mean + basis row . coefficients, summed apart for every fourth coefficient; what four leave
// over comes last and to the first sum, which began as the mean; then first + second and third + fourth are added.
// take_pivots: of a matrix m, m[row][c] -= m[k][row] m[k][c] for each of the columns c and, one after another, the
// pivots k.
struct FitLoops {
  void (*sum_rows)(const RowGroup& group, float* sums, double* right);
  void (*add_slopes)(const SlopeParts& parts, float* out);
  void (*add_shapes)(const ShapeRows& rows, float* out);
  void (*take_pivots)(const PivotRows& rows);
};
extern const FitLoops kFitLoopsPortable;
extern const FitLoops kFitLoopsAvx2;  // where IM2FIT_HAVE_AVX2
const FitLoops& fit_loops();          // the fastest that runs here

}  // namespace im2fit::body
