// SPDX-License-Identifier: Apache-2.0
// The tracker and the segmentation before held-out people and rooms: every section of the judgement, and its
// pictures.
#pragma once

#include <string>

#include "core/status.h"
#include "evaluation/tracker/tracker_report.h"

namespace im2fit::lab {

struct TrackerEvaluationOptions {
  TrackerSections sections;
  TrialOptions trials;
  ClipOptions clips;
  RoomTrialOptions rooms;
  GuidanceOptions guidance;
};

// Depends on the options except the numbers of threads.
Result<TrackerOutcomes> evaluate_tracker(const body::BodyModel& model, const JointModel& joint_model,
                                         const TrackerEvaluationOptions& options);

// The judged frames worth inspecting, into `folder`: the twenty worst of each condition (worst.png, worst-bare.png,
// worst-wide.png), twenty random ones (random.png), empty rooms with a person found (false-users.png), a guidance
// scene of each kind (guidance.png) and three of each that were wrong (guidance-wrong.png).
Status write_pictures(const body::BodyModel& model, const JointModel& joint_model,
                      const TrackerEvaluationOptions& options, const TrackerOutcomes& outcomes,
                      const std::string& folder);

}  // namespace im2fit::lab
