// SPDX-License-Identifier: Apache-2.0
// Which scene a trial shows, and the classes it is counted under.
#pragma once

#include "evaluation/tracker/scene_trials.h"
#include "train/tracker/tracker_scenes.h"

namespace im2fit::lab {

// The same scene at both resolutions. Depends on the options' seed, the trial's condition, subject and scene.
TrackerScene draw_trial_scene(const TrialOptions& options, const Trial& trial);

// `plan` converged.
Labels labels_of(const TrackerScene& plan, const Trial& trial);

}  // namespace im2fit::lab
