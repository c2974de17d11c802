// SPDX-License-Identifier: Apache-2.0
// Held-out people as a booth's scanner would give them: one mesh each, in a file of some unit, axis and format, with
// noise and holes, measured as `im2fit measure-scan` does, against the truth of their meshes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "body/model.h"
#include "core/measurement.h"
#include "core/status.h"
#include "evaluation/measurements/evaluation.h"
#include "index/index.h"
#include "perception/joints/tracker.h"

namespace im2fit::lab {

struct ScanStudyOptions {
  EvaluationOptions people;  // family, seed, subjects, pose
  float noise_mm = 1;        // of each vertex along its normal, standard deviation
  int holes = 5;             // round, of 25 to 50 mm radius, anywhere
  std::string keep_folder;   // where the scans are written and stay; "": a temporary folder
};

struct ScanOutcome {
  std::string file, unit, up;  // as written; `found`: as measure-scan names them
  std::string found, problem;  // `problem`: why there is no measurement
  bool measured = false, around = false;
  float turned_deg = 0;  // how far the camera was followed round the person
  MeasurementValues truth{}, values{}, low{}, high{};
  // Chest, waist and hip: the answered body's tape at the true height less the true girth; NaN: no section.
  std::array<float, 3> at_true_level_mm{};
  // Waist and hip: the tape round the scan itself at the true height, before noise and holes, less the true girth. It
  // is what the pose of the scan changes.
  std::array<float, 2> of_scan_mm{};
};

// The files are written with small programs of this room; the readers are the product's.
Result<std::vector<ScanOutcome>> study_scans(const body::BodyModel& model, const JointModel& joint_model,
                                             const index::Index& index, const ScanStudyOptions& options);

// A line for each scan, then bias, mean absolute error, and how many intervals hold the truth.
std::string text_of(const std::vector<ScanOutcome>& outcomes);

}  // namespace im2fit::lab
