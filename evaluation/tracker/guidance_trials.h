// SPDX-License-Identifier: Apache-2.0
// Scenes that each name one guidance code, and the codes they raise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "body/model.h"
#include "core/guidance.h"
#include "core/status.h"
#include "evaluation/tracker/upright_scene.h"
#include "perception/joints/tracker.h"
#include "train/common/parallel.h"

namespace im2fit::lab {

struct GuidanceOptions {
  int scenes = 100;                // per code
  std::vector<std::string> kinds;  // codes, or "OK"; empty: all
  std::uint64_t seed = 20'260'101;
  int threads = 1;  // does not change the result
  ProgressSink progress = {};
};

struct GuidanceOutcome {
  std::string kind;
  std::uint64_t scene = 0;
  GuidanceSet raised = 0;     // in half of the counted frames at least
  bool named = false;         // the code the scene names was raised (OK: no code)
  GuidanceSet unrelated = 0;  // raised, and neither named nor an allowed companion
  bool right() const { return named && unrelated == 0; }
};

// Shown to the whole engine but for the index. Error: the engine refuses a frame, which is a bug.
Result<std::vector<GuidanceOutcome>> run_guidance(const body::BodyModel& model, const JointModel& joint_model,
                                                  const GuidanceOptions& options);

// One scene again: its last frame.
Result<JudgedPicture> picture_of(const body::BodyModel& model, const JointModel& joint_model,
                                 const GuidanceOptions& options, const GuidanceOutcome& outcome);

}  // namespace im2fit::lab
