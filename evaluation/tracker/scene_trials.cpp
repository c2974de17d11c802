// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/scene_trials.h"

#include <algorithm>

#include "evaluation/tracker/trial_scenes.h"
#include "perception/observe/observe.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

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
