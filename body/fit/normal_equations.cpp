// SPDX-License-Identifier: Apache-2.0
#include "body/fit/normal_equations.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace im2fit::body {

NormalEquations::NormalEquations(std::size_t block_size, std::size_t block_max, std::size_t shared_size)
    : block_size_(block_size),
      shared_size_(shared_size),
      row_stride_(whole_lanes(block_size + shared_size)),
      matrix_((block_size * block_max + shared_size) * (block_size * block_max + shared_size)),
      right_(block_size * block_max + shared_size),
      step_(right_.size()),
      rows_(kRowGroup * row_stride_),
      sums_((block_size + shared_size) * row_stride_),
      right_sums_(row_stride_) {
  assert(block_size % 3 == 0 && block_size <= 3 * kTripleMax);
}

void NormalEquations::clear(std::size_t block_count) {
  blocks_ = block_count;
  assert(size() <= right_.size());
  for (std::size_t i = 0, n = size(); i < n; ++i)
    std::fill_n(matrix_.begin() + static_cast<std::ptrdiff_t>(i * n + i), n - i, 0.0);
  std::fill_n(right_.begin(), size(), 0.0);
}

void NormalEquations::add_prior(std::size_t unknown, double weight, double residual) {
  matrix_[unknown * size() + unknown] += weight;
  right_[unknown] += weight * residual;
}

void NormalEquations::begin_rows(std::size_t block, const RowColumns& columns) {
  block_ = block;
  columns_ = columns;
  width_ = 3 * columns.triple_count + shared_size_;
  row_count_ = 0;
  any_ = false;
  for (std::size_t i = 0; i < width_; ++i) {
    const std::size_t first = i - i % kRowLanes;
    std::fill_n(sums_.begin() + static_cast<std::ptrdiff_t>(i * row_stride_ + first), whole_lanes(width_) - first,
                0.0F);
  }
  std::fill_n(right_sums_.begin(), width_, 0.0);
}

void NormalEquations::add_row(float residual, float weight) {
  residual_[row_count_] = residual;
  weight_[row_count_] = weight;
  if (++row_count_ == kRowGroup) sum_group();
}

void NormalEquations::end_rows() {
  if (row_count_ > 0) {
    for (std::size_t r = row_count_; r < kRowGroup; ++r) {
      std::fill_n(rows_.begin() + static_cast<std::ptrdiff_t>(r * row_stride_), width_, 0.0F);
      residual_[r] = weight_[r] = 0;
    }
    sum_group();
  }
  if (any_) scatter();
}

void NormalEquations::sum_group() {
  loops_.sum_rows({rows_.data(), row_stride_, width_, weight_.data(), residual_.data()}, sums_.data(),
                  right_sums_.data());
  row_count_ = 0;
  any_ = true;
}

void NormalEquations::scatter() {
  const std::size_t n = size(), triples = columns_.triple_count;
  const auto place = [&](std::size_t t) { return block_at(block_) + 3 * std::size_t{columns_.triple[t]}; };
  const auto add = [](double* to, const float* from, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) to[i] += static_cast<double>(from[i]);
  };
  for (std::size_t t = 0; t < triples; ++t)
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t i = 3 * t + a;
      const float* sum = sums_.data() + i * row_stride_;
      double* row = matrix_.data() + (place(t) + a) * n;
      add(row + place(t) + a, sum + i, 3 - a);
      for (std::size_t u = t + 1; u < triples; ++u) add(row + place(u), sum + 3 * u, 3);
      add(row + shared_at(), sum + 3 * triples, shared_size_);
      right_[place(t) + a] += right_sums_[i];
    }
  for (std::size_t s = 0; s < shared_size_; ++s) {
    const std::size_t i = 3 * triples + s;
    add(matrix_.data() + (shared_at() + s) * n + shared_at() + s, sums_.data() + i * row_stride_ + i,
        shared_size_ - s);
    right_[shared_at() + s] += right_sums_[i];
  }
}

// U' U = matrix, U in its place, row by row; then U' y = right, U d = y.
bool NormalEquations::solve() {
  const std::size_t n = size(), shared = shared_at();
  const auto end_of = [&](std::size_t i) { return i < shared ? (i / block_size_ + 1) * block_size_ : n; };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t pivot = i < shared ? i / block_size_ * block_size_ : 0, end = end_of(i);
    loops_.take_pivots({matrix_.data(), n, i, pivot, i, i, end});
    if (i < shared) loops_.take_pivots({matrix_.data(), n, i, pivot, i, shared, n});
    double* row = matrix_.data() + i * n;
    if (!(row[i] > 0)) return false;
    const double root = std::sqrt(row[i]);
    for (std::size_t c = i; c < end; ++c) row[c] /= root;
    if (i < shared)
      for (std::size_t c = shared; c < n; ++c) row[c] /= root;
  }
  std::copy_n(right_.begin(), n, step_.begin());
  for (std::size_t i = 0; i < n; ++i) {
    const double* row = matrix_.data() + i * n;
    step_[i] /= row[i];
    for (std::size_t c = i + 1; c < end_of(i); ++c) step_[c] -= row[c] * step_[i];
    if (i < shared)
      for (std::size_t c = shared; c < n; ++c) step_[c] -= row[c] * step_[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* row = matrix_.data() + i * n;
    double sum = step_[i];
    for (std::size_t c = i + 1; c < end_of(i); ++c) sum -= row[c] * step_[c];
    if (i < shared)
      for (std::size_t c = shared; c < n; ++c) sum -= row[c] * step_[c];
    step_[i] = sum / row[i];
    if (!std::isfinite(step_[i])) return false;
  }
  return true;
}

}  // namespace im2fit::body
