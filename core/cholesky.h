// SPDX-License-Identifier: Apache-2.0
// Small dense systems with a symmetric positive definite matrix (Golub & Van Loan, Matrix Computations, algorithm
// 4.2.1): double precision, in place, no allocation, the same operations in the same order on every machine.
//
// Matrix is square and indexed m[row][column], Vector x[row]; both at least `order` long. Only the lower triangle is
// read and written.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace im2fit {

// The lower factor into m's place. A pivot is at least `pivot_min`, in the matrix's unit: a matrix that rounding has
// left without full rank still gives finite numbers.
template <typename Matrix>
void cholesky_factor(Matrix& m, std::size_t order, double pivot_min) {
  for (std::size_t i = 0; i < order; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = m[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
      m[i][j] = i == j ? std::sqrt(std::max(sum, pivot_min)) : sum / m[j][j];
    }
}

// Solves L L' x = x, L the factor.
template <typename Matrix, typename Vector>
void cholesky_solve(const Matrix& factor, std::size_t order, Vector& x) {
  for (std::size_t i = 0; i < order; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= factor[i][k] * x[k];
    x[i] /= factor[i][i];
  }
  for (std::size_t i = order; i-- > 0;) {
    for (std::size_t k = i + 1; k < order; ++k) x[i] -= factor[k][i] * x[k];
    x[i] /= factor[i][i];
  }
}

}  // namespace im2fit
