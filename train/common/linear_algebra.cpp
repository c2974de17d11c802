// SPDX-License-Identifier: Apache-2.0
#include "train/common/linear_algebra.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

constexpr std::ptrdiff_t kTileColumns = 8;
constexpr std::ptrdiff_t kGramDepth = 256;     // rows summed at a time
constexpr std::ptrdiff_t kFactorColumns = 64;  // of the Cholesky factor, found at a time

// Rows of a tile: 64 bytes, one vector of AVX-512 and two of AVX2.
template <class T>
constexpr std::ptrdiff_t kTileRows = 64 / static_cast<std::ptrdiff_t>(sizeof(T));

// Sums over `depth` of tile rows x tile columns, each element in order. `rows`: depth x kTileRows; `columns`: of each
// depth the first kTileColumns at a step of kTileRows.
template <class T>
[[gnu::always_inline]] inline void sum_tile(const T* rows, const T* columns, std::ptrdiff_t depth, T* out) {
  using Vector [[gnu::vector_size(64)]] = T;
  Vector sums[kTileColumns] = {};
  for (std::ptrdiff_t p = 0; p < depth; ++p, rows += kTileRows<T>, columns += kTileRows<T>) {
    Vector r;
    std::memcpy(&r, rows, sizeof r);
#pragma GCC unroll 8
    for (std::ptrdiff_t c = 0; c < kTileColumns; ++c) sums[c] += r * columns[c];
  }
  std::memcpy(out, sums, sizeof sums);
}
IM2FIT_SIMD_CLONES void sum_tile_of(const float* rows, const float* columns, std::ptrdiff_t depth, float* out) {
  sum_tile(rows, columns, depth, out);
}
IM2FIT_SIMD_CLONES void sum_tile_of(const double* rows, const double* columns, std::ptrdiff_t depth, double* out) {
  sum_tile(rows, columns, depth, out);
}

IM2FIT_SIMD_CLONES void take_away(double factor, const double* from, std::ptrdiff_t count, double* to) {
  for (std::ptrdiff_t i = 0; i < count; ++i) to[i] -= factor * from[i];
}

// sign * P P^T into the lower triangle of the matrix that begins at `out`, columns `stride` apart. `packed`: of P's
// `size` rows kTileRows at a time, filled up with zeros, each of them depth x kTileRows.
template <class T>
void add_square(const std::vector<T>& packed, std::ptrdiff_t size, std::ptrdiff_t depth, double sign, double* out,
                std::ptrdiff_t stride) {
  constexpr std::ptrdiff_t kRows = kTileRows<T>;
  T sums[kTileColumns * kRows];
  for (std::ptrdiff_t column = 0; column < size; column += kTileColumns) {
    const T* columns = packed.data() + column / kRows * kRows * depth + column % kRows;
    for (std::ptrdiff_t row = column / kRows * kRows; row < size; row += kRows) {
      sum_tile_of(packed.data() + row * depth, columns, depth, sums);
      const std::ptrdiff_t row_count = std::min(kRows, size - row);
      for (std::ptrdiff_t c = 0; c < std::min(kTileColumns, size - column); ++c) {
        double* to = out + (column + c) * stride + row;
        for (std::ptrdiff_t r = 0; r < row_count; ++r) to[r] += sign * static_cast<double>(sums[c * kRows + r]);
      }
    }
  }
}

// As add_square() reads it. at(row, depth): an element of P.
template <class T, class At>
void pack(std::ptrdiff_t size, std::ptrdiff_t depth, const At& at, std::vector<T>& packed) {
  constexpr std::ptrdiff_t kRows = kTileRows<T>;
  packed.assign(static_cast<std::size_t>((size + kRows - 1) / kRows * kRows * depth), T{});
  for (std::ptrdiff_t p = 0; p < depth; ++p)
    for (std::ptrdiff_t i = 0; i < size; ++i)
      packed[static_cast<std::size_t>((i / kRows * depth + p) * kRows + i % kRows)] = at(i, p);
}

template <class Rows>
void add_gram_of(const Rows& rows, Eigen::MatrixXd& gram) {
  const std::ptrdiff_t size = rows.cols();
  std::vector<typename Rows::Scalar> packed;
  for (std::ptrdiff_t first = 0; first < rows.rows(); first += kGramDepth) {
    const std::ptrdiff_t depth = std::min(kGramDepth, rows.rows() - first);
    pack(
        size, depth, [&](std::ptrdiff_t i, std::ptrdiff_t p) { return rows(first + p, i); }, packed);
    add_square(packed, size, depth, 1.0, gram.data(), gram.outerStride());
  }
}

// L of a = L L^T into the lower triangle of `a`. Where a direction is not positive its column becomes zero, with an
// infinite diagonal: solving by it gives zero.
void factor_positive(Eigen::MatrixXd& a) {
  const std::ptrdiff_t size = a.rows();
  std::vector<double> packed;
  for (std::ptrdiff_t first = 0; first < size; first += kFactorColumns) {
    const std::ptrdiff_t end = std::min(first + kFactorColumns, size);
    for (std::ptrdiff_t j = first; j < end; ++j) {
      double* column = &a(j, j);
      const std::ptrdiff_t left = size - j;
      for (std::ptrdiff_t p = first; p < j; ++p) take_away(a(j, p), &a(j, p), left, column);
      if (!(column[0] > 0)) {
        std::fill_n(column, left, 0.0);
        column[0] = INFINITY;
        continue;
      }
      const double root = std::sqrt(column[0]);
      column[0] = root;
      for (std::ptrdiff_t i = 1; i < left; ++i) column[i] /= root;
    }
    const std::ptrdiff_t left = size - end, depth = end - first;
    if (left == 0) break;
    pack(
        left, depth, [&](std::ptrdiff_t i, std::ptrdiff_t p) { return a(end + i, first + p); }, packed);
    add_square(packed, left, depth, -1.0, &a(end, end), a.outerStride());
  }
}

}  // namespace

void add_gram(const Eigen::Ref<const RowMatrixF, 0, Eigen::OuterStride<>>& rows, Eigen::MatrixXd& gram) {
  add_gram_of(rows, gram);
}
void add_gram(const Eigen::Ref<const RowMatrixD, 0, Eigen::OuterStride<>>& rows, Eigen::MatrixXd& gram) {
  add_gram_of(rows, gram);
}

Eigen::MatrixXd solve_positive(Eigen::MatrixXd a, const Eigen::MatrixXd& b) {
  factor_positive(a);
  Eigen::MatrixXd x = b;
  a.triangularView<Eigen::Lower>().solveInPlace(x);
  a.triangularView<Eigen::Lower>().adjoint().solveInPlace(x);
  return x;
}

Eigen::MatrixXd inverse_factor(Eigen::MatrixXd a) {
  factor_positive(a);
  Eigen::MatrixXd x = Eigen::MatrixXd::Identity(a.rows(), a.cols());
  a.triangularView<Eigen::Lower>().solveInPlace(x);
  return x;
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a * b;
}
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.transpose() * b;
}
RowMatrixF product_transposed(const RowMatrixF& a, const RowMatrixF& b) {
  return a * b.transpose();
}

}  // namespace im2fit::lab
