// SPDX-License-Identifier: Apache-2.0
#include "train/common/linear_algebra.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/rng.h"

namespace im2fit::lab {
namespace {

template <class Matrix>
Matrix drawn(std::ptrdiff_t rows, std::ptrdiff_t columns, std::uint64_t seed) {
  Rng rng(seed);
  Matrix out(rows, columns);
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t j = 0; j < columns; ++j) out(i, j) = static_cast<typename Matrix::Scalar>(rng.normal(0, 1));
  return out;
}

// Every element by itself, its terms in order: what any width of vectors must give.
template <class Matrix>
Eigen::MatrixXd gram_in_order(const Matrix& rows, std::ptrdiff_t together) {
  using T = typename Matrix::Scalar;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows.cols(), rows.cols());
  for (std::ptrdiff_t first = 0; first < rows.rows(); first += together)
    for (std::ptrdiff_t i = 0; i < rows.cols(); ++i)
      for (std::ptrdiff_t j = 0; j <= i; ++j) {
        T sum = 0;
        for (std::ptrdiff_t r = first; r < std::min(first + together, rows.rows()); ++r)
          sum += rows(r, i) * rows(r, j);
        out(i, j) += static_cast<double>(sum);
      }
  return out;
}

template <class Matrix>
void expect_gram_in_order(std::ptrdiff_t count, std::ptrdiff_t columns) {
  const auto rows = drawn<Matrix>(count, columns, static_cast<std::uint64_t>(columns));
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns, columns);
  add_gram(rows, gram);
  const Eigen::MatrixXd expected = gram_in_order(rows, 256);
  for (std::ptrdiff_t i = 0; i < columns; ++i)
    for (std::ptrdiff_t j = 0; j <= i; ++j)
      ASSERT_EQ(gram(i, j), expected(i, j)) << columns << ": " << i << ", " << j;
}

TEST(LinearAlgebra, GramsAreSummedInOrder) {
  for (const std::ptrdiff_t columns : {1, 3, 7, 8, 9, 15, 16, 17, 33, 70}) {
    expect_gram_in_order<RowMatrixF>(300, columns);
    expect_gram_in_order<RowMatrixD>(300, columns);
    expect_gram_in_order<RowMatrixF>(1, columns);
  }
}

TEST(LinearAlgebra, AGramIsAddedToWhatIsThere) {
  const auto rows = drawn<RowMatrixD>(40, 5, 1);
  Eigen::MatrixXd once = Eigen::MatrixXd::Zero(5, 5), twice = once;
  add_gram(rows, once);
  add_gram(rows, twice);
  add_gram(rows, twice);
  EXPECT_EQ(twice(4, 2), 2 * once(4, 2));
}

// Independent of the factor: by the equations of the solution, and as near to it as Eigen's.
TEST(LinearAlgebra, SolutionsFulfilTheirEquations) {
  for (const std::ptrdiff_t size : {1, 2, 7, 8, 9, 63, 64, 65, 72, 130, 200}) {
    const Eigen::MatrixXd half = drawn<Eigen::MatrixXd>(size + 20, size, 3);
    Eigen::MatrixXd a = half.transpose() * half;
    a.diagonal().array() += 0.1;
    const Eigen::MatrixXd b = drawn<Eigen::MatrixXd>(size, 4, 4);
    Eigen::MatrixXd lower = a;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(NAN);
    const Eigen::MatrixXd x = solve_positive(lower, b);
    const double off = (a * x - b).norm(), eigens = (a * a.llt().solve(b) - b).norm();
    EXPECT_LT(off, 4 * eigens + 1e-13 * b.norm()) << size;
    const Eigen::MatrixXd inverse = inverse_factor(lower);
    EXPECT_LT((inverse * a * inverse.transpose() - Eigen::MatrixXd::Identity(size, size)).cwiseAbs().maxCoeff(), 1e-9)
        << size;
  }
}

TEST(LinearAlgebra, ADirectionWithoutVarianceIsLeftOut) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3, 3);
  a(0, 0) = 4;
  a(2, 2) = 2;
  const Eigen::MatrixXd x = solve_positive(a, Eigen::MatrixXd::Constant(3, 1, 8));
  EXPECT_DOUBLE_EQ(x(0), 2);
  EXPECT_EQ(x(1), 0);
  EXPECT_DOUBLE_EQ(x(2), 4);
}

TEST(LinearAlgebra, EigenvectorsRiseAndAreOrthogonal) {
  const Eigen::MatrixXd half = drawn<Eigen::MatrixXd>(30, 12, 9);
  const Eigen::MatrixXd a = transposed_product(half, half);
  const SymmetricEigen eigen = symmetric_eigen(a);
  EXPECT_LT((a * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-10 * a.norm());
  for (int i = 1; i < 12; ++i) EXPECT_LE(eigen.values(i - 1), eigen.values(i));
}

TEST(LinearAlgebra, ProductsAreWhatTheirNamesSay) {
  const Eigen::MatrixXd a = drawn<Eigen::MatrixXd>(5, 7, 1), b = drawn<Eigen::MatrixXd>(7, 3, 2);
  EXPECT_NEAR(product(a, b)(4, 2), a.row(4).dot(b.col(2)), 1e-12);
  EXPECT_NEAR(transposed_product(b, a.transpose())(2, 4), a.row(4).dot(b.col(2)), 1e-12);
  const RowMatrixF f = a.cast<float>(), g = b.transpose().cast<float>();
  EXPECT_NEAR(static_cast<double>(product_transposed(f, g)(4, 2)), a.row(4).dot(b.col(2)), 1e-5);
}

}  // namespace
}  // namespace im2fit::lab
