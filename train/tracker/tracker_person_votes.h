// SPDX-License-Identifier: Apache-2.0
// Training the person score: people against false detections of the segmenter in empty rooms.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "body/model.h"
#include "perception/joints/tracker.h"
#include "train/tracker/tracker_votes.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::lab {

// What the segmenter detects in pictures of people and of empty rooms, as examples for the person votes.
struct DetectionPlan {
  int people_count = 0;  // pictures, of person_mix()
  int room_count = 0;    // pictures, of draw_empty_room()
  std::uint64_t seed = 1;
  int thread_count = 1;  // does not change the result
};

// Every detection of the segmenter in a first frame, confirmed or candidate, each followed by its mirror image; every
// second mirror image as if no floor were seen and no shape known. yes: the person shown. The model's own votes are
// not used.
VoteExamples collect_detections(const body::BodyModel& model, const JointModel& joint_model,
                                std::span<const joints::Anchor> anchors, const DetectionPlan& plan,
                                const std::function<void(double)>& progress);

// `joint_model` has no person votes yet. Pictures are new ones, of `options.image_count` empty rooms and a
// quarter as many of people: on its training images the model's confidence is too high. No trees when
// they show one kind only.
VoteTrees train_person_votes(const body::BodyModel& model, const JointModel& joint_model, const TrainOptions& options,
                             const std::function<void(double)>& progress);

}  // namespace im2fit::lab
