// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/scene_trials.h"

#include <algorithm>

#include "core/rng.h"
#include "perception/observe/observe.h"
#include "train/common/parallel.h"
#include "train/tracker/tracker_scenes.h"

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

// The same scene at both resolutions. Depends on the options' seed, the trial's condition, subject and scene.
TrackerScene draw_trial_scene(const TrialOptions& options, const Trial& trial) {
  const auto number = trial.subject * kScenesMax + static_cast<std::uint64_t>(trial.scene);
  Rng rng = Rng::for_item(options.seed, kTrialStream + static_cast<std::uint64_t>(trial.condition), number);
  TrackerScene plan = draw_tracker_scene(mix_of(trial.condition), rng, Family::held_out);
  plan.intrinsics = kinect_intrinsics(trial.width, trial.width * 3 / 4);
  if (options.hidden_floor) plan.scene.floor = false;
  return plan;
}

// `plan` converged.
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

// As on the device; for bare scenes the joint tracker alone, on the true mask.
class Observer {
 public:
  Observer(const Intrinsics& k, const JointModel& joint_model, TrialCondition condition)
      : own_mask_(condition != TrialCondition::bare),
        k_(k),
        sensor_(k.width, k.height, joint_model),
        tracker_(joint_model),
        mask_(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)) {}

  void observe(UprightScene& scene) {
    if (own_mask_) {
      const Detection detection = sensor_.sense(scene.depth(), k_, mask());
      found_ = detection.person.found;
      joints_ = detection.joints;
      return;
    }
    const MaskView truth = scene.truth_mask();
    std::copy_n(truth.pixels, mask_.size(), mask_.begin());
    const Person person = person_of_mask(truth);
    const bool same_person = found_;
    found_ = person.found;
    joints_ = tracker_.track(scene.depth(), mask(), k_, person, same_person);
  }
  MaskImage mask() { return {mask_.data(), k_.width, k_.height}; }
  bool found() const { return found_; }
  const JointSet& joints() const { return joints_; }

 private:
  bool own_mask_;
  Intrinsics k_;
  PersonDetector sensor_;
  JointTracker tracker_;
  std::vector<std::uint8_t> mask_;
  bool found_ = false;
  JointSet joints_;
};

Shot shot_of(const TrackerScene& plan) {
  return {plan.scene, plan.sensor, plan.intrinsics, plan.seed};
}

JointFrame judge(UprightScene& scene, Observer& observer, Ious& iou) {
  Overlap overlap = overlap_of(scene.depth(), observer.mask(), scene.truth_mask());
  Overlap clear = overlap_of(scene.depth(), observer.mask(), scene.truth_mask(), scene.mixed_mask());
  if (!observer.found()) overlap.ours = overlap.both = clear.ours = clear.both = 0;
  iou = {clear.iou(), overlap.iou()};
  return judge_joints(observer.joints(), scene.truth(), scene.intrinsics(), overlap.finding());
}

TrialOutcome run_trial(const body::BodyModel& model, const Subject& subject, const JointModel& joint_model,
                       const TrialOptions& options, const Trial& trial) {
  TrackerScene plan = draw_trial_scene(options, trial);
  UprightScene scene(model, subject, shot_of(plan));
  plan.place(scene.staged());
  Observer observer(scene.intrinsics(), joint_model, trial.condition);
  TrialOutcome outcome;
  outcome.trial = trial;
  for (std::uint64_t frame = 0; frame <= kConvergedFrame; ++frame) {
    scene.show(frame);
    observer.observe(scene);
    if (frame == 0) outcome.cold = judge(scene, observer, outcome.iou_cold);
  }
  outcome.converged = judge(scene, observer, outcome.iou_converged);
  outcome.labels = labels_of(plan, trial);
  return outcome;
}

std::vector<Trial> trials_of(const TrialOptions& options, std::uint64_t subject) {
  std::vector<Trial> trials;
  for (std::size_t c = 0; c < kConditionCount; ++c) {
    if (!options.wanted[c]) continue;
    const auto condition = static_cast<TrialCondition>(c);
    for (int scene = 0; scene < options.scenes_per_subject; ++scene)
      for (const int width : kTrialWidths) trials.push_back({condition, width, subject, scene});
  }
  return trials;
}

}  // namespace

std::vector<TrialOutcome> run_trials(const body::BodyModel& model, const JointModel& joint_model,
                                     const TrialOptions& options) {
  const auto subjects = static_cast<std::uint64_t>(options.subjects);
  const std::size_t per_subject = trials_of(options, 0).size();
  std::vector<TrialOutcome> outcomes(static_cast<std::size_t>(subjects) * per_subject);
  for_each_item(
      subjects, options.threads,
      [&](std::uint64_t s) {
        const Subject subject = draw_subject(model, Family::held_out, options.seed, s);
        std::size_t place = static_cast<std::size_t>(s) * per_subject;
        for (const Trial& trial : trials_of(options, s))
          outcomes[place++] = run_trial(model, subject, joint_model, options, trial);
      },
      begin_progress(options.progress, "people", subjects));
  return outcomes;
}

JudgedPicture picture_of(const body::BodyModel& model, const JointModel& joint_model, const TrialOptions& options,
                         const Trial& trial, bool converged) {
  const Subject subject = draw_subject(model, Family::held_out, options.seed, trial.subject);
  UprightScene scene(model, subject, shot_of(draw_trial_scene(options, trial)));
  Observer observer(scene.intrinsics(), joint_model, trial.condition);
  for (std::uint64_t frame = 0; frame <= (converged ? kConvergedFrame : 0); ++frame) {
    scene.show(frame);
    observer.observe(scene);
  }
  const DepthView depth = scene.depth();
  const MaskView mask = observer.mask();
  const auto count = static_cast<std::ptrdiff_t>(depth.width) * depth.height;
  return {scene.intrinsics(),
          {depth.pixels, depth.pixels + count},
          {mask.pixels, mask.pixels + count},
          observer.found(),
          observer.joints(),
          scene.truth()};
}

}  // namespace im2fit::lab
