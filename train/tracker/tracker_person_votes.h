// SPDX-License-Identifier: Apache-2.0
// Training the person score: people against false detections of the segmenter in empty rooms.
#pragma once

#include <functional>

#include "body/model.h"
#include "perception/joints/tracker.h"
#include "train/tracker/tracker_votes.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::lab {

// `joint_model` has no person votes yet. Pictures are new ones, of `options.image_count` empty rooms and a
// quarter as many of people: on its training images the model's confidence is too high. No trees when
// they show one kind only.
VoteTrees train_person_votes(const body::BodyModel& model, const JointModel& joint_model, const TrainOptions& options,
                             const std::function<void(double)>& progress);

}  // namespace im2fit::lab
