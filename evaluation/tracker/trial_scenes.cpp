// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/trial_scenes.h"

#include "core/rng.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kTrialStream = 0x7247A1;
constexpr std::uint64_t kScenesMax = 1000;  // of a subject and condition

TrackerMix mix_of(TrialCondition condition) {
  switch (condition) {
    case TrialCondition::full:
      return full_conditions_mix();
    case TrialCondition::bare:
      return bare_mix();
    case TrialCondition::wide:
      break;
  }
  TrackerMix mix = training_mix();
  mix.wide_share = 1;
  return mix;
}

const char* distance_class(float distance_mm) {
  constexpr std::pair<float, const char*> kClasses[] = {
      {1500, "below 1.5 m"}, {2000, "1.5 to 2 m"}, {2500, "2 to 2.5 m"}, {3000, "2.5 to 3 m"}, {3500, "3 to 3.5 m"}};
  for (const auto& [below, name] : kClasses)
    if (distance_mm < below) return name;
  return "from 3.5 m";
}

const char* clothing_name(Clothing clothing) {
  switch (clothing) {
    case Clothing::none:
      return "none";
    case Clothing::tight:
      return "tight";
    case Clothing::normal:
      return "normal";
    case Clothing::loose:
      return "loose";
    case Clothing::hanging:
      return "hanging";
    case Clothing::garments:
      break;
  }
  return "garments";
}

// The targets distinguish calm standing, which Psi is as well, and of free poses.
std::string pose_group(PoseClass pose) {
  if (pose == PoseClass::psi) return "calm";
  return std::string(kPoseClassNames[static_cast<std::size_t>(pose)]);
}

}  // namespace

TrackerScene draw_trial_scene(const TrialOptions& options, const Trial& trial) {
  const auto number = trial.subject * kScenesMax + static_cast<std::uint64_t>(trial.scene);
  Rng rng = Rng::for_item(options.seed, kTrialStream + static_cast<std::uint64_t>(trial.condition), number);
  TrackerScene plan = draw_tracker_scene(mix_of(trial.condition), rng, Family::held_out);
  plan.intrinsics = kinect_intrinsics(trial.width, trial.width * 3 / 4);
  if (options.hidden_floor) plan.scene.floor = false;
  return plan;
}

Labels labels_of(const TrackerScene& plan, const Trial& trial) {
  const bool portrait = plan.rotate_deg % 180 != 0;
  Labels labels = {{kPoseGroup, pose_group(plan.pose_class)},
                   {"resolution", trial.width == 640 ? "640x480" : "320x240"},
                   {"view", plan.back_view ? "back" : "front"},
                   {"distance", distance_class(plan.distance_mm)},
                   {"sensor", plan.kind == SensorKind::structured_light ? "structured light" : "time of flight"},
                   {"mounting", portrait ? "portrait" : "landscape"},
                   {"clothing", clothing_name(plan.clothing)},
                   {"furniture", plan.furnished ? "some" : "none"},
                   {"others", plan.others > 0 ? "some" : "none"},
                   {"whole", plan.whole ? "yes" : "cut off"}};
  if (plan.pose_class == PoseClass::psi) labels.emplace_back("calm", "psi");
  if (plan.pose_class == PoseClass::calm) labels.emplace_back("calm", "relaxed or A");
  return labels;
}

}  // namespace im2fit::lab
