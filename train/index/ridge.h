// SPDX-License-Identifier: Apache-2.0
// Workstation side: group-wise ridge regression from moments, with whole subjects held out fold by fold. The moments
// are of all samples, the rows of those that choices are judged by.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "train/common/linear_algebra.h"
#include "train/index/moments.h"

namespace im2fit::index {

using lab::RowMatrixF;

// One row a capture.
struct TrainingRows {
  RowMatrixF features;                 // standardised and clipped
  Eigen::MatrixXd targets;             // standardised
  std::vector<std::uint32_t> subject;  // 0 .. subject count - 1
  std::vector<int> frame_count;        // fused behind the capture
  std::vector<int> distance_mm;        // camera to person
  std::vector<int> fold;               // of the subject: never two folds for one subject
  int fold_count = 0;
};

struct RidgeFit {
  RowMatrixF weights;  // target x feature
  Eigen::VectorXf bias;
  RidgeFit of_targets(std::span<const std::ptrdiff_t> targets) const;
  // A row each of features' rows.
  RowMatrixF predict(const RowMatrixF& features) const;
};

// A regularisation: penalty per group of features, and how much of the measured noise is added on top.
struct Penalty {
  std::vector<double> group;  // variance units of a standardised feature
  double noise = 0;           // times the within-subject covariance
};

class RidgeTrainer {
 public:
  // `groups`: features per group, in order. Rows and moments (one for each fold) must outlive this.
  RidgeTrainer(const TrainingRows& rows, const std::vector<Moments>& folds, std::vector<std::uint32_t> groups);

  // Without the rows of `held_out_fold`; -1: all rows.
  RidgeFit fit(const Penalty& penalty, int held_out_fold) const;
  // Mean absolute error of the first `target_count` targets over some held-out folds, in standard deviations.
  double held_out_error(const Penalty& penalty) const;
  struct Choice {
    Penalty penalty;
    double error = 0;
    std::vector<double> error_without;  // per group
  };
  // Coordinate descent over the groups' penalties, judged on held-out subjects.
  Choice choose(int judged_target_count);
  // Every row answered by the fit that did not see its subject.
  Eigen::MatrixXd cross_fitted(const Penalty& penalty) const;
  bool has_noise() const { return noise_count_ > 0; }

 private:
  void accumulate_noise();
  Eigen::MatrixXd predict(const RidgeFit& fit, std::span<const std::int32_t> rows) const;

  const TrainingRows& rows_;
  std::vector<std::uint32_t> groups_;
  std::vector<std::vector<std::int32_t>> fold_rows_;
  const std::vector<Moments>& folds_;
  Moments total_;
  Eigen::MatrixXd noise_;  // within-subject covariance, lower triangle
  double noise_count_ = 0;
  int judged_target_count_ = 0;
  int judged_fold_count_ = 1;
};

}  // namespace im2fit::index
