// SPDX-License-Identifier: Apache-2.0
// Which scene a trial shows, and the classes it is counted under.
#pragma once

#include "apps/im2fit-lab/tracker/scene_trials.h"
#include "synth/tracker_scenes.h"

namespace im2fit::apps {

// The same scene at both resolutions. Depends on the options' seed, the trial's condition, subject and scene.
synth::TrackerScene draw_trial_scene(const TrialOptions& options, const Trial& trial);

// `plan` settled.
Labels labels_of(const synth::TrackerScene& plan, const Trial& trial);

}  // namespace im2fit::apps
