// SPDX-License-Identifier: Apache-2.0
// Workstation side: the sums behind a regression, exact, so that they can be made in any order and in any number of
// parts and still give the same bits.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace im2fit::index {

// Learned from are features in steps of 1/4096 within +-5 (kernels/standardise) and targets in steps of 1/1024 within
// +-16: their products are multiples of 2^-24 below 2^8.4, and sums of 2^24 of them fit the 53 bits of a double.
inline constexpr double kTargetStep = 1.0 / 1024;
inline constexpr double kTargetBound = 16;
double rounded_target(double standardised);

struct Moments {
  double count = 0;
  Eigen::MatrixXd gram;   // lower triangle of sum z z'
  Eigen::MatrixXd cross;  // sum z y'
  Eigen::VectorXd feature_sum;
  Eigen::VectorXd target_sum;

  Moments(std::ptrdiff_t features, std::ptrdiff_t targets);
  Moments& operator+=(const Moments& other);
};

// Accumulates rows, fold by fold.
class FoldMoments {
 public:
  FoldMoments(std::ptrdiff_t features, std::ptrdiff_t targets, int fold_count);
  // z: as floats, multiples of 1/4096; y: of kTargetStep.
  void add(int fold, std::span<const float> z, const Eigen::VectorXd& y);
  // Of all rows added so far.
  const std::vector<Moments>& folds();

 private:
  struct Pending {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> z, y;
    std::ptrdiff_t rows = 0;
  };
  void flush(std::size_t fold);
  std::vector<Moments> folds_;
  std::vector<Pending> pending_;
};

}  // namespace im2fit::index
