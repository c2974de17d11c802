// SPDX-License-Identifier: Apache-2.0
#include "body/fit/normal_equations.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/rng.h"

namespace im2fit::body {
namespace {

constexpr std::size_t kBlock = 51, kShared = 40;

// The same equations as a dense matrix of float64.
struct Dense {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
  explicit Dense(std::size_t n)
      : a(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n))),
        b(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n))) {}
};

// Random rows of random columns in both, `row_count` to a group.
void add_rows(NormalEquations& equations, Dense& dense, std::size_t block, int row_count, Rng& rng) {
  RowColumns columns;
  for (std::uint8_t t = 0; t < kBlock / 3; ++t)
    if (rng.index(3) == 0) columns.triple[columns.triple_count++] = t;
  equations.begin_rows(block, columns);
  for (int r = 0; r < row_count; ++r) {
    const auto slopes = equations.next_row();
    Eigen::VectorXd row = Eigen::VectorXd::Zero(dense.b.size());
    for (std::size_t i = 0; i < slopes.size(); ++i) {
      slopes[i] = static_cast<float>(rng.uniform(-3, 3));
      const std::size_t triples = 3 * columns.triple_count;
      const std::size_t at = i < triples ? equations.block_at(block) + 3 * std::size_t{columns.triple[i / 3]} + i % 3
                                         : equations.shared_at() + i - triples;
      row(static_cast<Eigen::Index>(at)) = static_cast<double>(slopes[i]);
    }
    const auto residual = static_cast<float>(rng.uniform(-9, 9)), weight = static_cast<float>(rng.uniform(0, 0.5));
    equations.add_row(residual, weight);
    dense.a += static_cast<double>(weight) * row * row.transpose();
    dense.b += static_cast<double>(weight) * static_cast<double>(residual) * row;
  }
  equations.end_rows();
}

TEST(NormalEquations, StepIsEigensForOneAndTwoBlocks) {
  Rng rng(77);
  NormalEquations equations(kBlock, 2, kShared);
  for (const std::size_t blocks : {std::size_t{2}, std::size_t{1}, std::size_t{2}}) {
    equations.clear(blocks);
    const std::size_t n = equations.size();
    ASSERT_EQ(n, blocks * kBlock + kShared);
    Dense dense(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double weight = rng.uniform(0.5, 2), residual = rng.uniform(-1, 1);
      equations.add_prior(i, weight, residual);
      dense.a(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += weight;
      dense.b(static_cast<Eigen::Index>(i)) += weight * residual;
    }
    for (int g = 0; g < 40; ++g) add_rows(equations, dense, static_cast<std::size_t>(g) % blocks, rng.index(30), rng);
    const double scale = dense.a.diagonal().maxCoeff();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i; j < n; ++j)
        ASSERT_NEAR(equations.matrix()[i * n + j],
                    dense.a(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)), 1e-6 * scale);
      ASSERT_NEAR(equations.right_side()[i], dense.b(static_cast<Eigen::Index>(i)), 1e-9 * dense.b.norm());
    }
    const Eigen::VectorXd expected = dense.a.ldlt().solve(dense.b);
    ASSERT_TRUE(equations.solve());
    for (std::size_t i = 0; i < n; ++i)
      ASSERT_NEAR(equations.step()[i], expected(static_cast<Eigen::Index>(i)), 1e-5 * expected.norm()) << i;
  }
}

TEST(NormalEquations, WhatHasNoSolutionIsRefused) {
  NormalEquations equations(kBlock, 2, kShared);
  equations.clear(1);
  EXPECT_FALSE(equations.solve());  // nothing known of anything
  equations.clear(1);
  for (std::size_t i = 0; i < equations.size(); ++i) equations.add_prior(i, i == 60 ? -1 : 1, 1);
  EXPECT_FALSE(equations.solve());
  equations.clear(1);
  for (std::size_t i = 0; i < equations.size(); ++i)
    equations.add_prior(i, 1, i == 60 ? std::numeric_limits<double>::quiet_NaN() : 1);
  EXPECT_FALSE(equations.solve());
}

}  // namespace
}  // namespace im2fit::body
