// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/eval_tracker.h"

#include <fmt/core.h>

#include <algorithm>

#include "apps/common/program.h"
#include "apps/common/progress.h"
#include "core/file.h"
#include "evaluation/tracker/guidance_scenes.h"
#include "evaluation/tracker/tracker_evaluation.h"

namespace im2fit::apps {
namespace {

struct SectionName {
  const char* name;
  bool TrackerSections::*wanted;
};
constexpr SectionName kSections[] = {
    {"joints", &TrackerSections::joints},     {"segmentation", &TrackerSections::segmentation},
    {"people", &TrackerSections::people},     {"empty", &TrackerSections::empty},
    {"guidance", &TrackerSections::guidance}, {"confidence", &TrackerSections::confidence},
};

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::vector<std::string> section_words() {
  std::vector<std::string> words;
  for (const SectionName& section : kSections) words.emplace_back(section.name);
  return words;
}

std::vector<std::string> scene_words() {
  std::vector<std::string> words(kConditionNames.begin(), kConditionNames.end());
  for (const std::string& kind : guidance_kinds()) words.push_back(kind);
  return words;
}

// Kinds of one sort; all of them when none of that sort is named.
std::vector<std::string> chosen(const std::vector<std::string>& all, const std::vector<std::string>& named) {
  std::vector<std::string> out;
  for (const std::string& word : all)
    if (contains(named, word)) out.push_back(word);
  return out.empty() ? all : out;
}

TrackerEvaluationOptions options_of(const TrackerEvalWords& words, const TrackerEvalRun& run) {
  TrackerEvaluationOptions options;
  for (const SectionName& section : kSections)
    options.sections.*section.wanted = words.only.empty() || contains(words.only, section.name);
  const auto conditions = chosen({kConditionNames.begin(), kConditionNames.end()}, words.scenes);
  for (std::size_t c = 0; c < kConditionCount; ++c)
    options.trials.wanted[c] = contains(conditions, kConditionNames[c]);
  // Masks and chances are judged on full scenes only.
  if (!options.sections.joints) options.trials.wanted = {true, false, false};
  options.trials.subjects = run.subjects;
  options.trials.scenes_per_subject = words.scenes_per_subject;
  options.clips.clips = words.clips;
  options.clips.frames = words.clip_frames;
  options.rooms.frames = words.empty_frames;
  options.trials.hidden_floor = options.rooms.hidden_floor = words.hidden_floor;
  options.guidance.scenes = words.guidance_scenes;
  options.guidance.kinds = chosen(guidance_kinds(), words.scenes);
  options.trials.seed = options.clips.seed = options.rooms.seed = options.guidance.seed = run.seed;
  options.trials.progress = options.clips.progress = options.rooms.progress = options.guidance.progress =
      show_progress;
  options.trials.threads = options.clips.threads = options.rooms.threads = options.guidance.threads = run.threads;
  return options;
}

}  // namespace

void add_tracker_words(cli::App& sub, TrackerEvalWords& words, const std::vector<cli::Option*>& others) {
  cli::Option* tracker = sub.add_flag("--tracker", words.wanted, "Evaluate the tracker: masks, joints, guidance");
  for (cli::Option* other : others) tracker->excludes(other);
  const auto add = [&](cli::Option* option) { return option->needs(tracker); };
  add(sub.add_option("--only", words.only, "With --tracker: only these sections")->delimiter(','))
      ->one_of(section_words());
  add(sub.add_option("--scenes", words.scenes,
                     "With --tracker: only these conditions (full, bare, wide) or guidance codes")
          ->delimiter(','))
      ->one_of(scene_words());
  add(sub.add_option("--scenes-per-subject", words.scenes_per_subject,
                     "With --tracker: scenes of each condition, for each person"))
      ->range(1, 1000)
      ->capture_default_str();
  add(sub.add_option("--clips", words.clips, "With --tracker: two-person clips"))
      ->range(1, 100000)
      ->capture_default_str();
  add(sub.add_option("--clip-frames", words.clip_frames, "With --tracker: frames of a clip, 30 a second"))
      ->range(20, 100000)
      ->capture_default_str();
  add(sub.add_option("--empty-frames", words.empty_frames, "With --tracker: frames of empty rooms"))
      ->range(1, 10000000)
      ->capture_default_str();
  add(sub.add_option("--guidance-scenes", words.guidance_scenes, "With --tracker: scenes per guidance code"))
      ->range(1, 100000)
      ->capture_default_str();
  add(sub.add_flag("--hidden-floor", words.hidden_floor,
                   "With --tracker: the floor has no depth, in empty rooms and in scenes of people"));
  add(sub.add_option("--pictures", words.pictures, "With --tracker: folder for contact sheets (PNG)"))
      ->type_name("DIR");
}

Result<int> run_tracker_eval(const body::BodyModel& model, const JointModel& joint_model,
                             const TrackerEvalWords& words, const TrackerEvalRun& run) {
  const TrackerEvaluationOptions options = options_of(words, run);
  const auto outcomes = evaluate_tracker(model, joint_model, options);
  if (!outcomes) return outcomes.error();
  TrackerReport report = tracker_report(*outcomes, options.sections);
  report.seed = run.seed;
  report.subjects = run.subjects;
  report.model = joint_model.provenance();
  if (!run.json_path.empty())
    if (const auto written = write_file_atomically(run.json_path, json_of(report)); !written) return written.error();
  if (!words.pictures.empty())
    if (const auto written = write_pictures(model, joint_model, options, *outcomes, words.pictures); !written)
      return written.error();
  fmt::print("{}", run.json ? json_of(report) : text_of(report));
  return kExitOk;
}

}  // namespace im2fit::apps
