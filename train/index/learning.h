// SPDX-License-Identifier: Apache-2.0
// Workstation side: the input of a regression, from samples: standardised features, standardised targets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "index/regression.h"
#include "train/index/sample.h"

namespace im2fit::index {

struct FeatureScale {
  std::vector<float> mean, scale;  // scale 0: a feature that never varies
  // What was not measured counts as the mean.
  explicit FeatureScale(const std::vector<Sample>& samples);
  // Of other values than samples' features.
  explicit FeatureScale(const std::vector<const std::vector<float>*>& rows);
  // As a query does it (kernels/standardise): multiples of 1/4096.
  void standardise(std::span<const float> feature, std::span<float> out);

 private:
  std::vector<std::int16_t> raw_;
};

// Measurements, sex, and directions of the body that those leave open (latents), standardised over subjects.
class TargetSpace {
 public:
  explicit TargetSpace(const std::vector<Sample>& samples);
  std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(mean_.size()); }
  // Multiples of kTargetStep.
  Eigen::VectorXd operator()(const Sample& sample) const;
  // Only these targets from now on.
  void keep(const std::vector<std::ptrdiff_t>& targets);
  // Measurements and sex alone, standardised.
  Eigen::VectorXd measured(const MeasurementValues& truth, bool woman) const;
  double mean(std::size_t target) const { return mean_[target]; }
  double scale(std::size_t target) const { return scale_[target]; }
  const std::vector<double>& means() const { return mean_; }
  const std::vector<double>& scales() const { return scale_; }

 private:
  Eigen::VectorXd measured(const Sample& sample) const { return measured(sample.truth, sample.woman); }
  Eigen::VectorXd deviation(const Sample& sample) const;
  void learn_latents(const std::vector<const Sample*>& subjects);
  std::vector<double> mean_, scale_;
  Eigen::VectorXd body_mean_, body_inverse_sd_;
  Eigen::MatrixXd body_by_measured_;  // regression of the body on the measured targets
  Eigen::MatrixXd latent_;            // body x latents
};

// Deals subjects to folds as they come, equally many to each.
class FoldDealer {
 public:
  FoldDealer(std::uint64_t seed, int fold_count) : seed_(seed), order_(static_cast<std::size_t>(fold_count)) {}
  // Samples of a subject follow each other.
  int fold_of(std::uint64_t subject);

 private:
  std::uint64_t seed_;
  std::vector<int> order_;  // of the folds, drawn anew for each round
  std::uint64_t dealt_ = 0;
  std::uint64_t last_ = 0;
  int fold_ = 0;
};

}  // namespace im2fit::index
