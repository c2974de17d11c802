// SPDX-License-Identifier: Apache-2.0
// Learning to tell people from what the segmenter takes for people in rooms without any.
#pragma once

#include <functional>

#include "body/model.h"
#include "lab/tracker_training/tracker_votes.h"
#include "lab/tracker_training/train_tracker.h"
#include "perception/joints/tracker.h"

namespace im2fit::lab {

// `joint_model` has no votes for somebody yet. Pictures are new ones, of `options.image_count` empty rooms and a
// quarter as many of people: on its own images the model is surer of its joints than of anybody else's. No trees when
// they show one kind only.
VoteTrees train_person_votes(const body::BodyModel& model, const JointModel& joint_model, const TrainOptions& options,
                             const std::function<void(double)>& progress);

}  // namespace im2fit::lab
