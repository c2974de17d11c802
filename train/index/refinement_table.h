// SPDX-License-Identifier: Apache-2.0
// Workstation side: the rows a refinement learns from, and its ridge regressions over them: penalties chosen across
// folds of people, and answers to clothes that a regression has not met.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "train/common/linear_algebra.h"
#include "train/index/learning.h"

namespace im2fit::index {

inline constexpr int kRefinementFolds = 3;
inline constexpr std::size_t kRefinementSampleMin = 150;  // fewer teach too little

struct LinearFit {
  Eigen::MatrixXd weights;  // value x target
  Eigen::VectorXd bias;
};

// Sums behind a ridge regression, of weighted rows.
struct RegressionSums {
  std::ptrdiff_t count = 0;
  double weight = 0;
  Eigen::MatrixXd gram, cross;  // lower triangle of z z^T; z y^T
  Eigen::VectorXd z, y;
  RegressionSums(std::ptrdiff_t values, std::ptrdiff_t targets);
  void add(const lab::RowMatrixF& rows, const Eigen::MatrixXd& targets, const Eigen::VectorXd& weights);
  void add(const RegressionSums& other, int sign);
};

// `unlike`: lower triangle, covariance of the difference between two captures of the same body.
LinearFit solve(const RegressionSums& sums, const Eigen::MatrixXd& unlike, const Eigen::VectorXd& penalties);

using Repeats = std::vector<std::array<std::ptrdiff_t, 2>>;  // rows of the same body, one after the other

// The rows of one kind as a query sees them, and the sums behind their regressions.
struct RefinementTable {
  FeatureScale scale;  // means and scales as the file keeps them
  lab::RowMatrixF z;
  Eigen::MatrixXd y;                                                  // standardised targets
  Eigen::VectorXd weight;                                             // of a row
  std::array<std::vector<std::ptrdiff_t>, kRefinementFolds> of_fold;  // rows
  std::vector<RegressionSums> folds;
  RegressionSums all;
  Eigen::MatrixXd unlike;  // mean of d d^T, lower triangle; d between captures of the same body

  RefinementTable(const std::vector<const std::vector<float>*>& values, Eigen::MatrixXd targets,
                  Eigen::VectorXd weights, const std::vector<int>& fold_of_row);
  RegressionSums sums_of(const std::vector<std::ptrdiff_t>& rows) const;
  // Mean of d d^T, lower triangle, over pairs of rows.
  Eigen::MatrixXd unlike_of(const Repeats& repeats) const;
  RegressionSums without(const RegressionSums& some) const;
  void answer(const LinearFit& fit, const std::vector<std::ptrdiff_t>& rows, Eigen::MatrixXd& out) const;
};

// The penalty that answers people of other folds best, in variances of a value, and those answers. `shares`: of it,
// by value.
struct CrossFit {
  double penalty = 0;
  Eigen::MatrixXd answer;
};
CrossFit choose_penalty(const RefinementTable& table, const Eigen::VectorXd& shares);

// Answers to people in clothes by regressions that met neither them nor any clothes of their kind: real wardrobes
// hold cuts that none of the training people wear. `met_none`: for whom enough others are left to learn from.
Eigen::MatrixXd answer_unknown_clothes(const RefinementTable& table, const std::vector<int>& kind_of_row,
                                       const Repeats& repeats, const Eigen::VectorXd& penalties,
                                       std::vector<bool>& met_none);

}  // namespace im2fit::index
