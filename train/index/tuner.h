// SPDX-License-Identifier: Apache-2.0
// Workstation side: from cross-fitted regressions to the projected space, the codes, and the correction that answers
// best on held-out subjects.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "index/format.h"
#include "train/index/calibration.h"
#include "train/index/encoder.h"
#include "train/index/ridge.h"

namespace im2fit::index {

class Tuner {
 public:
  // `regressed`: cross-fitted, a row a capture.
  Tuner(const TrainingRows& rows, const Eigen::MatrixXd& regressed);
  void run(int dimensions);  // 0: choose

  // What the file stores.
  MetaRecord meta;  // dimensions, methods, penalties and grid only
  Encoder encoder;
  std::vector<float> error_map, place_map;
  std::vector<float> quadratic;  // zeros where it is not used
  std::array<float, kDimensionMax> dimension_bits{};
  std::vector<HeldOut> held_out;      // up to kCalibrationRowMax answers
  MeasurementValues nearest_error{};  // mean absolute, standardised

 private:
  struct Trial;
  void make_space();
  void choose_dimensions(int wanted);
  void scale_codes(int dimensions);
  void make_maps();
  void fit_quadratic();
  void scale_residuals();
  void choose_correction();
  void answer_held_out();
  Targets row_of(const Eigen::MatrixXd& m, std::ptrdiff_t row) const;
  Position regressed_place(std::ptrdiff_t row) const { return encoder.place_of(row_of(regressed_, row)); }
  Position true_place(std::ptrdiff_t row) const { return encoder.place_of(row_of(rows_.targets, row)); }
  Trial trial() const;
  // The nearest `count` entries of other subjects.
  std::span<Neighbour> neighbours_of(Trial& trial, std::ptrdiff_t row, const Coordinates& grid, int count) const;
  std::ptrdiff_t nearest_body(const Trial& trial, std::span<const Neighbour> neighbours,
                              const Position& wanted) const;
  Coordinates grid_of(std::ptrdiff_t row) const;
  double nearest_entry_error(Trial& trial) const;
  Eigen::MatrixXd local_errors(Trial& trial, const Eigen::MatrixXd& base, const LocalOptions& options,
                               int count) const;
  std::vector<std::ptrdiff_t> judged_rows(std::ptrdiff_t count_max) const;

  const TrainingRows& rows_;
  const Eigen::MatrixXd& regressed_;
  int target_count_ = 0;
  int captures_max_ = 1;  // of one subject
  Eigen::MatrixXd full_projection_;
  Eigen::MatrixXd error_covariance_, signal_covariance_;
  Eigen::MatrixXd quadratic_correction_;  // cross-fitted, a row a capture
};

}  // namespace im2fit::index
