// SPDX-License-Identifier: Apache-2.0
// `eval --tracker`: the words of the command line, and the run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/cli.h"
#include "body/model.h"
#include "core/status.h"
#include "perception/joints/tracker.h"

namespace im2fit::lab {}

namespace im2fit::apps {

using namespace lab;  // what commands are about

struct TrackerEvalWords {
  bool wanted = false;
  std::vector<std::string> only;    // sections; empty: all
  std::vector<std::string> scenes;  // conditions and guidance codes; empty: all
  int scenes_per_subject = 2;
  int clips = 50;
  int clip_frames = 300;
  int empty_frames = 10'000;
  int guidance_scenes = 100;
  bool hidden_floor = false;
  std::string pictures;
};

// `others`: options without a meaning beside --tracker.
void add_tracker_words(cli::App& sub, TrackerEvalWords& words, const std::vector<cli::Option*>& others);

struct TrackerEvalRun {
  int subjects = 200;
  std::uint64_t seed = 0;
  int threads = 1;
  std::string json_path;
  bool json = false;
};
Result<int> run_tracker_eval(const body::BodyModel& model, const JointModel& joint_model,
                             const TrackerEvalWords& words, const TrackerEvalRun& run);

}  // namespace im2fit::apps
