// SPDX-License-Identifier: Apache-2.0
// The heavy parts of a regression, compiled once: of Eigen, what takes seconds to compile wherever it is used; sums
// of squares and the Cholesky factor, of our own. Those take the widest vectors the machine has and give the same
// bits with any: each element is summed in order, which in Eigen depends on the machine's vectors and caches.
// Functions may be called from any thread. Workstation code.
#pragma once

#include <Eigen/Core>

namespace im2fit::lab {

using RowMatrixF = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMatrixD = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Adds rows^T rows to the lower triangle of `gram` (columns x columns of `rows`); the values above the diagonal are
// undefined. Of floats, some hundred rows at a time are summed as floats.
void add_gram(const Eigen::Ref<const RowMatrixF, 0, Eigen::OuterStride<>>& rows, Eigen::MatrixXd& gram);
void add_gram(const Eigen::Ref<const RowMatrixD, 0, Eigen::OuterStride<>>& rows, Eigen::MatrixXd& gram);

// The solution x of a x = b. `a`: symmetric and positive definite, of which the lower triangle is read. A direction
// in which it is not positive, by rounding, is left out: zero in x.
Eigen::MatrixXd solve_positive(Eigen::MatrixXd a, const Eigen::MatrixXd& b);

// L^-1 of a = L L^T, of the same `a`.
Eigen::MatrixXd inverse_factor(Eigen::MatrixXd a);

struct SymmetricEigen {
  Eigen::VectorXd values;   // rising
  Eigen::MatrixXd vectors;  // columns of length 1, of either sign
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
// a^T b.
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
// a b^T.
RowMatrixF product_transposed(const RowMatrixF& a, const RowMatrixF& b);

}  // namespace im2fit::lab
