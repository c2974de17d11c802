// SPDX-License-Identifier: Apache-2.0
// Weighted least squares over one set of unknowns that all equations know and several blocks of which an equation
// knows one: shape behind every view, a pose in each.
//
// The step d that makes the sum of w (r - j d)^2 smallest solves (J' W J) d = J' W r, by Cholesky (Golub and Van
// Loan, Matrix Computations, 4.2). With the blocks before the shared unknowns the matrix is an arrow,
//     | B0  .   S0 |
//     | .   B1  S1 |
//     | S0' S1' Q  |
// and so is its factor: the zeros between blocks are never touched.
//
// + - * / and sqrt in written order; no allocation after construction.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body/fit/rows.h"

namespace im2fit::body {

// Which unknowns some rows have slopes for: triples of their block, in rising order, then all shared ones.
inline constexpr std::size_t kTripleMax = 24;
struct RowColumns {
  std::array<std::uint8_t, kTripleMax> triple{};  // unknowns 3 t, 3 t + 1, 3 t + 2 of the block
  std::size_t triple_count = 0;
};

// The weight of a residual whose square grows as a line beyond `outlier` (Charbonnier's loss).
inline float robust_weight(float weight, float residual, float outlier) {
  const float out = residual / outlier;
  return weight / std::sqrt(1 + out * out);
}

class NormalEquations {
 public:
  // block_size: a multiple of 3, at most 3 kTripleMax.
  NormalEquations(std::size_t block_size, std::size_t block_max, std::size_t shared_size);

  // No equations, `block_count` blocks in use.
  void clear(std::size_t block_count);
  std::size_t size() const { return blocks_ * block_size_ + shared_size_; }
  std::size_t block_at(std::size_t block) const { return block * block_size_; }
  std::size_t shared_at() const { return blocks_ * block_size_; }

  // weight (residual - d[unknown])^2
  void add_prior(std::size_t unknown, double weight, double residual);

  // Equations of one block and one kind of columns: begin, then for each row the slopes (of `columns`' triples, then
  // of the shared unknowns: columns.triple_count x 3 + shared_size values) and its residual and weight, then end.
  // Products are summed in float32 over 8 rows at a time, in float64 beyond one begin and end: the steps are made
  // anew in each iteration, so an error of 1e-6 in the matrix moves no result; the right side is float64 throughout.
  void begin_rows(std::size_t block, const RowColumns& columns);
  std::span<float> next_row() { return {rows_.data() + row_count_ * row_stride_, width_}; }
  void add_row(float residual, float weight);
  void end_rows();

  // False when the matrix is not positive definite or a step is not finite. Overwrites the equations.
  bool solve();
  std::span<const double> step() const { return {step_.data(), size()}; }
  // For tests: the upper triangle as added up so far, entries at row * size() + column.
  std::span<const double> matrix() const { return {matrix_.data(), size() * size()}; }
  std::span<const double> right_side() const { return {right_.data(), size()}; }

 private:
  void sum_group();
  void scatter();

  const FitLoops& loops_ = fit_loops();
  std::size_t block_size_, shared_size_, row_stride_;
  std::size_t blocks_ = 0;
  std::vector<double> matrix_;  // upper triangle, row-major
  std::vector<double> right_, step_;

  std::size_t block_ = 0;
  RowColumns columns_;
  std::size_t width_ = 0, row_count_ = 0;
  std::vector<float> rows_;  // kRowGroup x row_stride_
  std::array<float, kRowGroup> weight_{}, residual_{};
  std::vector<float> sums_;         // width_ x row_stride_, upper triangle and what sum_rows adds to its vectors
  std::vector<double> right_sums_;  // width_
  bool any_ = false;
};

}  // namespace im2fit::body
