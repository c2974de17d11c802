// SPDX-License-Identifier: Apache-2.0
#include "core/cholesky.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

#include "core/rng.h"

namespace im2fit {
namespace {

constexpr std::size_t kSide = 20, kOrder = 17;  // smaller than its memory
using Matrix = std::array<std::array<double, kSide>, kSide>;
using Vector = std::array<double, kSide>;

// B B' of `rank` columns, and of them so much of the unit matrix.
Matrix symmetric(Rng& rng, std::size_t rank, double diagonal) {
  Matrix b{}, m{};
  for (auto& row : b)
    for (std::size_t k = 0; k < rank; ++k) row[k] = rng.normal(0, 1);
  for (std::size_t i = 0; i < kSide; ++i)
    for (std::size_t j = 0; j < kSide; ++j) {
      for (std::size_t k = 0; k < rank; ++k) m[i][j] += b[i][k] * b[j][k];
      if (i == j) m[i][j] += diagonal;
    }
  return m;
}

TEST(Cholesky, SolvesWhatAMatrixMadeOfAVector) {
  Rng rng(41);
  for (int trial = 0; trial < 100; ++trial) {
    Matrix m = symmetric(rng, kOrder, 0.5);
    Vector truth{}, x{};
    for (std::size_t i = 0; i < kOrder; ++i) truth[i] = rng.normal(0, 3);
    for (std::size_t i = 0; i < kOrder; ++i)
      for (std::size_t j = 0; j < kOrder; ++j) x[i] += m[i][j] * truth[j];
    // Values above the diagonal and beyond the order are not read.
    for (std::size_t i = 0; i < kSide; ++i)
      for (std::size_t j = 0; j < kSide; ++j)
        if (j > i || i >= kOrder) m[i][j] = std::nan("");
    cholesky_factor(m, kOrder, 1e-12);
    cholesky_solve(m, kOrder, x);
    for (std::size_t i = 0; i < kOrder; ++i) ASSERT_NEAR(x[i], truth[i], 1e-6) << trial << ' ' << i;
  }
}

TEST(Cholesky, OfLessThanFullRankGivesFiniteNumbers) {
  Rng rng(42);
  Matrix m = symmetric(rng, 5, 0);
  Vector x{};
  x.fill(1);
  cholesky_factor(m, kOrder, 1e-12);
  cholesky_solve(m, kOrder, x);
  for (std::size_t i = 0; i < kOrder; ++i) EXPECT_TRUE(std::isfinite(x[i])) << i;
}

}  // namespace
}  // namespace im2fit
