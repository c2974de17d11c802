// SPDX-License-Identifier: Apache-2.0
// Rooms without people: chairs, coat stands, boxes, a box the size of a dog. Every user found there is false.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "body/model.h"
#include "evaluation/tracker/upright_scene.h"
#include "perception/joints/tracker.h"
#include "train/common/parallel.h"

namespace im2fit::lab {

struct RoomTrialOptions {
  int frames = 10'000;  // in rooms of kFramesPerRoom
  std::uint64_t seed = 20'260'101;
  int threads = 1;  // does not change the result
  ProgressSink progress = {};
  bool hidden_floor = false;  // the floor gives no depth
};
inline constexpr int kFramesPerRoom = 20;

struct RoomOutcome {
  std::uint64_t room = 0;
  std::string kind;
  std::uint64_t frames = 0;
  std::uint64_t false_users = 0;  // frames with a person found
  std::uint64_t first_false = 0;  // the first of them
};

std::vector<RoomOutcome> run_rooms(const body::BodyModel& model, const JointModel& joint_model,
                                   const RoomTrialOptions& options);

// One room again: the first frame with a person found, else its last.
JudgedPicture picture_of(const body::BodyModel& model, const JointModel& joint_model, const RoomTrialOptions& options,
                         const RoomOutcome& outcome);

}  // namespace im2fit::lab
