// SPDX-License-Identifier: Apache-2.0
// Held-out people who step round once before a fixed camera, measured by body/fit/turn_fitter from the device's own
// masks, against the truth of their meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "body/model.h"
#include "core/measurement.h"
#include "core/status.h"
#include "evaluation/measurements/evaluation.h"
#include "perception/joints/tracker.h"
#include "train/common/parallel.h"

namespace im2fit::lab {

struct TurnStudyOptions {
  EvaluationOptions people;  // family, seed, noise, picture size, subjects, threads
  float degrees = 360;
  float seconds_min = kStepRoundSecondsMin, seconds_max = kStepRoundSecondsMax;  // of a full turn
  int view_count = 8;  // pictures fitted, the front's among them; 1 to body::kTurnViewMax
};

inline constexpr std::array<const char*, 3> kTurnLimbs = {"mid_thigh_girth", "calf_girth", "upper_arm_girth"};
inline constexpr std::size_t kTurnLimbCount = kTurnLimbs.size();

struct TurnOutcome {
  bool woman = false;
  bool front_found = false;  // the front could be fitted to
  bool measured = false;
  MeasurementValues truth{}, measured_values{};  // NaN: not known
  float turned_deg = 0, true_turn_deg = 0;
  int frames = 0, frames_followed = 0, frames_without_person = 0;
  float yaw_error_deg = 0;  // mean absolute, of the followed frames
  float surface_mm = 0;     // mean over the views
  std::vector<float> views_deg;
  // Chest, waist and hip: height of the section less the true one (NaN: no section), and the girth of the fitted body
  // at the true height less the true girth. Mid-thigh, calf and upper arm (data/tape): the truth, of the fused
  // surface, and of the one body that the product would answer with (docs/one-body.md), its values being those
  // measured here.
  std::array<float, kTurnLimbCount> true_limbs{}, fused_limbs{}, answered_limbs{};
  bool has_levels = false;
  std::array<float, 3> level_error_mm{}, at_true_level_mm{};
};

Result<std::vector<TurnOutcome>> study_turns(const body::BodyModel& model, const JointModel& joint_model,
                                             const TurnStudyOptions& options);

// Bias, mean absolute error and its 95th percentile of each measurement, and what became of the turns.
std::string text_of(const std::vector<TurnOutcome>& outcomes);

}  // namespace im2fit::lab
