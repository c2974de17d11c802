// SPDX-License-Identifier: Apache-2.0
// Held-out synthetic people through the whole device path, against the truth measured on their meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "body/model.h"
#include "engine/engine.h"
#include "index/index.h"
#include "index/raw_nearest.h"
#include "kernels/joints/tracker.h"
#include "synth/features.h"

namespace im2fit::apps {

struct EvaluationOptions {
  int subjects = 200;
  std::uint64_t seed = 20'260'101;
  bool noise = true;  // false: a perfect sensor in an empty room
  int frames = 30;    // accepted frames wanted; three times as many are shown at most
  int width = 640, height = 480;
  int threads = 1;  // does not change the result
};

// The person `index` of an evaluation, and where the camera stands.
struct HeldOutPerson {
  synth::Subject subject;
  synth::CaptureOptions capture;
};
HeldOutPerson draw_person(const body::BodyModel& model, const EvaluationOptions& options, std::uint64_t index);

// One person, one session.
struct Outcome {
  bool woman = false;
  bool measured = false;
  GuidanceSet guidance_seen = 0;
  std::uint64_t frames_seen = 0;
  MeasurementValues truth{};
  index::Answer answer;
  MeasurementValues paper{};  // NaN where not measured
  bool has_raw = false;
  index::RawNearest::Match raw;
  // Over all frames and joints with a person found.
  int joint_count = 0;
  int joints_within_100mm = 0;
  double joint_error_sum_mm = 0;
};

// `raw`: the paper's nearest neighbour, or null. Depends on the options except threads.
Result<std::vector<Outcome>> evaluate(const body::BodyModel& model, const JointModel& joint_model,
                                      const index::Index& index, const index::RawNearest* raw,
                                      const EvaluationOptions& options);

}  // namespace im2fit::apps
