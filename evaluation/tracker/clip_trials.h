// SPDX-License-Identifier: Apache-2.0
// Two people whose paths cross: does the tracker stay with the one it began with?
#pragma once

#include <cstdint>
#include <vector>

#include "body/model.h"
#include "perception/joints/tracker.h"
#include "train/common/parallel.h"

namespace im2fit::lab {

struct ClipOptions {
  int clips = 50;
  int frames = 300;  // ten seconds
  std::uint64_t seed = 20'260'101;
  int threads = 1;  // does not change the result
  ProgressSink progress = {};
};

struct ClipOutcome {
  std::uint64_t clip = 0;
  std::uint64_t frames = 0;
  std::uint64_t found = 0;        // frames whose mask is one person's
  std::uint64_t switches = 0;     // the chosen id's mask came to lie on the other person
  std::uint64_t id_switches = 0;  // a person in view got another id, or an id went to the other person
};

std::vector<ClipOutcome> run_clips(const body::BodyModel& model, const JointModel& joint_model,
                                   const ClipOptions& options);

}  // namespace im2fit::lab
