// SPDX-License-Identifier: Apache-2.0
// Workstation side: from cross-fitted regressions to the projected space, the codes, and the correction that answers
// best on held-out subjects.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "index/calibration.h"
#include "index/code_tree.h"
#include "index/format.h"
#include "index/ridge.h"

namespace im2fit::index {

class Tuner {
 public:
  // `regressed`: cross-fitted, a row a capture. `entry_targets`: true standardised targets, a row a subject.
  Tuner(const TrainingRows& rows, const Eigen::MatrixXd& regressed, const Eigen::MatrixXd& entry_targets);
  void run(int dimensions);  // 0: choose

  // What the file stores.
  MetaRecord meta;  // dimensions, methods, penalties and grid only
  std::vector<float> projection;
  Coordinates steps{};
  std::vector<float> inverse_spread;
  std::vector<float> quadratic;
  std::vector<std::int8_t> point_code;
  std::vector<std::int16_t> point_residual;
  std::vector<float> residual_scale;
  std::vector<std::int8_t> entry_code;
  std::array<float, kDimensionMax> dimension_bits{};
  std::vector<HeldOut> held_out;      // up to kCalibrationRowMax answers
  MeasurementValues nearest_error{};  // mean absolute, standardised

 private:
  void make_space();
  void choose_dimensions(int wanted);
  void encode(int dimensions);
  void fit_quadratic();
  void choose_correction();
  void set_residuals(const Eigen::MatrixXd& residuals);
  void answer_held_out();
  Targets row_of(const Eigen::MatrixXd& m, std::ptrdiff_t row) const;
  Position position_of(const Eigen::MatrixXd& m, std::ptrdiff_t row, int dimensions) const;
  double nearest_entry_error(int dimensions) const;
  std::span<Neighbour> neighbours_of(CodeSearch& search, std::ptrdiff_t row, const Coordinates& grid,
                                     std::span<const std::uint32_t> subject, int count) const;
  Eigen::MatrixXd local_errors(const CodeTree& tree, const Eigen::MatrixXd& base, const LocalOptions& options,
                               int count) const;
  std::vector<std::ptrdiff_t> judged_rows(std::ptrdiff_t count_max) const;

  const TrainingRows& rows_;
  const Eigen::MatrixXd& regressed_;
  const Eigen::MatrixXd& entry_targets_;
  std::vector<std::uint32_t> entry_subject_;
  int target_count_ = 0;
  int captures_max_ = 1;  // of one subject
  Eigen::MatrixXd full_projection_;
  Eigen::MatrixXd quadratic_correction_;  // cross-fitted, a row a capture; empty when not used
};

}  // namespace im2fit::index
