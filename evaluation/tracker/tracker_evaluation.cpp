// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/tracker_evaluation.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "core/file.h"
#include "core/rng.h"
#include "evaluation/tracker/contact_sheet.h"

namespace im2fit::lab {
namespace {

constexpr std::size_t kSheetPictures = 20;
constexpr std::uint64_t kRandomStream = 0x5A3B1E;

// A frame's badness: the mean error of its joints; not found, or another taken, is worse than any joint.
double badness_mm(const JointFrame& frame) {
  if (frame.finding == Finding::other) return 3e4;
  if (frame.finding == Finding::none) return 2e4;
  double sum = 0;
  int count = 0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (frame.in_picture[j]) sum += frame.error_mm[j], ++count;
  return count > 0 ? sum / count : 0;
}

std::vector<const TrialOutcome*> worst_of(const std::vector<TrialOutcome>& trials, TrialCondition condition) {
  std::vector<const TrialOutcome*> sorted;
  for (const TrialOutcome& trial : trials)
    if (trial.trial.condition == condition) sorted.push_back(&trial);
  std::stable_sort(sorted.begin(), sorted.end(), [](const TrialOutcome* a, const TrialOutcome* b) {
    return badness_mm(a->converged) > badness_mm(b->converged);
  });
  // A scene once, at its worse resolution.
  std::set<std::pair<std::uint64_t, int>> seen;
  std::erase_if(sorted, [&](const TrialOutcome* t) {
    return !seen.insert({t->trial.subject, t->trial.scene}).second;
  });
  sorted.resize(std::min(sorted.size(), kSheetPictures));
  return sorted;
}

std::vector<const TrialOutcome*> random_of(const std::vector<TrialOutcome>& trials, std::uint64_t seed) {
  std::vector<const TrialOutcome*> all;
  all.reserve(trials.size());
  for (const TrialOutcome& trial : trials) all.push_back(&trial);
  Rng rng = Rng::for_item(seed, kRandomStream, 0);
  const std::size_t count = std::min(all.size(), kSheetPictures);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(all[i], all[i + static_cast<std::size_t>(rng.index(static_cast<int>(all.size() - i)))]);
  all.resize(count);
  return all;
}

Result<Canvas> sheet_of(const body::BodyModel& model, const JointModel& joint_model, const TrialOptions& options,
                        const std::vector<const TrialOutcome*>& trials) {
  std::vector<SheetCell> cells;
  cells.reserve(trials.size());
  for (const TrialOutcome* trial : trials)
    cells.push_back(trial_cell(picture_of(model, joint_model, options, trial->trial, true), *trial));
  return contact_sheet(cells);
}

Result<Canvas> sheet_of(const body::BodyModel& model, const JointModel& joint_model, const GuidanceOptions& options,
                        const std::vector<const GuidanceOutcome*>& scenes) {
  std::vector<SheetCell> cells;
  cells.reserve(scenes.size());
  for (const GuidanceOutcome* scene : scenes) {
    const auto picture = picture_of(model, joint_model, options, *scene);
    if (!picture) return picture.error();
    cells.push_back(guidance_cell(*picture, *scene));
  }
  return contact_sheet(cells);
}

// Of each kind the first `count` that are wrong, or simply the first.
std::vector<const GuidanceOutcome*> some_of_each_kind(const std::vector<GuidanceOutcome>& scenes, int count,
                                                      bool wrong_only) {
  std::vector<const GuidanceOutcome*> out;
  std::map<std::string, int> taken;
  for (const GuidanceOutcome& scene : scenes)
    if (!(wrong_only && scene.right()) && taken[scene.kind]++ < count) out.push_back(&scene);
  return out;
}

Result<Canvas> sheet_of(const body::BodyModel& model, const JointModel& joint_model, const RoomTrialOptions& options,
                        const std::vector<const RoomOutcome*>& rooms) {
  std::vector<SheetCell> cells;
  cells.reserve(rooms.size());
  for (const RoomOutcome* room : rooms)
    cells.push_back(room_cell(picture_of(model, joint_model, options, *room), *room));
  return contact_sheet(cells);
}

std::vector<const RoomOutcome*> with_false_users(const std::vector<RoomOutcome>& rooms) {
  std::vector<const RoomOutcome*> out;
  for (const RoomOutcome& room : rooms)
    if (room.false_users > 0 && out.size() < kSheetPictures) out.push_back(&room);
  return out;
}

// Where sheets go, and the first error met.
class Sheets {
 public:
  explicit Sheets(std::string folder) : folder_(std::move(folder)), status_(make_directory(folder_)) {}
  template <class Options, class Outcome>
  void add(const std::string& name, const body::BodyModel& model, const JointModel& joint_model,
           const Options& options, const std::vector<const Outcome*>& outcomes) {
    if (!status_ || outcomes.empty()) return;
    const auto sheet = sheet_of(model, joint_model, options, outcomes);
    if (!sheet) {
      status_ = sheet.error();
      return;
    }
    const auto png = sheet->png();
    status_ = png ? write_file_atomically(std::filesystem::path(folder_) / name, *png) : png.error();
  }
  const Status& status() const { return status_; }

 private:
  std::string folder_;
  Status status_;
};

}  // namespace

Result<TrackerOutcomes> evaluate_tracker(const body::BodyModel& model, const JointModel& joint_model,
                                         const TrackerEvaluationOptions& options) {
  TrackerOutcomes outcomes;
  const TrackerSections& wanted = options.sections;
  if (wanted.joints || wanted.segmentation || wanted.confidence)
    outcomes.trials = run_trials(model, joint_model, options.trials);
  if (wanted.people) outcomes.clips = run_clips(model, joint_model, options.clips);
  if (wanted.empty) outcomes.rooms = run_rooms(model, joint_model, options.rooms);
  if (wanted.guidance) {
    auto guidance = run_guidance(model, joint_model, options.guidance);
    if (!guidance) return guidance.error();
    outcomes.guidance = std::move(*guidance);
  }
  return outcomes;
}

Status write_pictures(const body::BodyModel& model, const JointModel& joint_model,
                      const TrackerEvaluationOptions& options, const TrackerOutcomes& outcomes,
                      const std::string& folder) {
  Sheets sheets(folder);
  if (outcomes.trials) {
    for (std::size_t c = 0; c < kConditionCount; ++c) {
      const auto condition = static_cast<TrialCondition>(c);
      const std::string name =
          condition == TrialCondition::full ? "worst.png" : fmt::format("worst-{}.png", name_of(condition));
      sheets.add(name, model, joint_model, options.trials, worst_of(*outcomes.trials, condition));
    }
    sheets.add("random.png", model, joint_model, options.trials, random_of(*outcomes.trials, options.trials.seed));
  }
  if (outcomes.rooms)
    sheets.add("false-users.png", model, joint_model, options.rooms, with_false_users(*outcomes.rooms));
  if (outcomes.guidance) {
    sheets.add("guidance.png", model, joint_model, options.guidance, some_of_each_kind(*outcomes.guidance, 1, false));
    sheets.add("guidance-wrong.png", model, joint_model, options.guidance,
               some_of_each_kind(*outcomes.guidance, 3, true));
  }
  return sheets.status();
}

}  // namespace im2fit::lab
