// SPDX-License-Identifier: Apache-2.0
// Held-out people in drawn scenes: the tracker's results of single frames and of the sixth in a row.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/tracker/statistics.h"
#include "evaluation/tracker/upright_scene.h"
#include "perception/joints/tracker.h"
#include "train/common/parallel.h"

namespace im2fit::lab {

enum class TrialCondition : int {
  full,  // clothing, hair, furniture, other people, sensor noise; our own segmentation
  bare,  // naked and alone, the mask given
  wide,  // as full, and all the tracker was trained for: cut off, 1 to 4 m, cameras high, low and tilted
};
inline constexpr std::size_t kConditionCount = 3;
inline constexpr std::array<const char*, kConditionCount> kConditionNames = {"full", "bare", "wide"};
constexpr const char* name_of(TrialCondition condition) {
  return kConditionNames[static_cast<std::size_t>(condition)];
}
inline constexpr int kTrialWidths[] = {640, 320};
inline constexpr std::uint64_t kConvergedFrame = 5;  // "after five frames"

inline constexpr const char* kPoseGroup = "pose group";  // the label targets select by: calm, free, ...

// What a frame is counted under: ("pose", "free"), ("view", "back") ...
using Labels = std::vector<std::pair<std::string, std::string>>;

struct TrialOptions {
  int subjects = 200;
  int scenes_per_subject = 2;  // of each condition, each at both resolutions
  std::uint64_t seed = 20'260'101;
  int threads = 1;  // does not change the result
  ProgressSink progress = {};
  std::array<bool, kConditionCount> wanted = {true, true, true};  // by TrialCondition
  bool hidden_floor = false;  // the floor gives no depth: black carpet, glossy tiles, a masked background
};

struct Trial {
  TrialCondition condition = TrialCondition::full;
  int width = 640;  // of the landscape sensor: 640x480 or 320x240
  std::uint64_t subject = 0;
  int scene = 0;  // of the subject
};

// Of our mask and the true one, 0..1.
struct Ious {
  double clear = 0;       // without flying pixels, whose depth belongs to no person (VirtualScene::mixed_mask)
  double with_mixed = 0;  // which count as the person's
};

struct TrialOutcome {
  Trial trial;
  Labels labels;
  JointFrame cold, converged;    // frame 0 and frame kConvergedFrame
  Ious iou_cold, iou_converged;  // of our own masks: not bare
};

// Scenes of one subject stand together, 640 before 320. Depends on the options except threads.
std::vector<TrialOutcome> run_trials(const body::BodyModel& model, const JointModel& joint_model,
                                     const TrialOptions& options);

// One trial again.
JudgedPicture picture_of(const body::BodyModel& model, const JointModel& joint_model, const TrialOptions& options,
                         const Trial& trial, bool converged);

}  // namespace im2fit::lab
