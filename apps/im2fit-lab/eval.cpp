// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <optional>

#include "apps/common/data_files.h"
#include "apps/common/paths.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/eval_report.h"
#include "apps/im2fit-lab/eval_tracker.h"
#include "apps/im2fit-lab/evaluation.h"
#include "apps/im2fit-lab/parallel.h"
#include "apps/im2fit-lab/samples.h"
#include "base/file.h"

namespace im2fit::apps {
namespace {

struct EvalCommand {
  EvaluationOptions evaluation;
  std::string condition = "noise";
  std::string body = default_body_path();
  std::string joint_model = default_tracker_path();
  std::string index = default_index_path();
  std::string samples;
  std::string json_path;
  bool json = false;
  TrackerEvalWords tracker;
};

// The samples behind the index, for the paper's way of answering. Absent shards leave that column empty.
Result<std::optional<index::RawNearest>> load_raw(const EvalCommand& options) {
  const std::string work_dir = options.samples.empty() ? options.index + ".samples" : options.samples;
  auto noted = noted_samples(work_dir);
  if (!noted) {
    if (!options.samples.empty()) return noted.error();
    fmt::print(stderr, "eval: no samples in {}: the raw nearest neighbour column stays empty\n", work_dir);
    return std::optional<index::RawNearest>{};
  }
  noted->body = options.body;
  noted->tracker = options.joint_model;
  noted->threads = options.evaluation.threads;
  std::optional<index::RawNearest> raw(std::in_place);
  const auto made = make_samples(*noted, [&](const index::Sample& sample) { raw->add(sample); });
  if (!made) return made.error();
  return raw;
}

Result<int> run_eval(const EvalCommand& options) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto tracker = Tracker::load(options.joint_model);
  if (!tracker) return tracker.error();
  if (options.tracker.wanted)
    return run_tracker_eval(*model, tracker->model(), options.tracker,
                            {options.evaluation.subjects, options.evaluation.seed, options.evaluation.threads,
                             options.json_path, options.json});
  const auto index = load_index(options.index);
  if (!index) return index.error();
  const auto raw = load_raw(options);
  if (!raw) return raw.error();
  EvaluationOptions evaluation = options.evaluation;
  evaluation.noise = options.condition == "noise";
  const auto outcomes = evaluate(*model, tracker->model(), *index, raw->has_value() ? &**raw : nullptr, evaluation);
  if (!outcomes) return outcomes.error();
  const Report report = report_of(*outcomes, options.condition);
  if (!options.json_path.empty())
    if (const auto written = write_file_atomically(options.json_path, json_of(report)); !written)
      return written.error();
  fmt::print("{}", options.json ? json_of(report) : text_of(report));
  return kExitOk;
}

}  // namespace

void add_eval(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<EvalCommand>();
  auto& evaluation = options->evaluation;
  evaluation.threads = default_threads();
  auto* sub = add_command<EvalCommand>(
      app, chosen, "eval", "Measure held-out synthetic people and compare with the truth; or judge the tracker",
      "  im2fit-lab eval --subjects 200 --condition noise\n"
      "  im2fit-lab eval --subjects 40 --condition bare --out eval.json\n"
      "  im2fit-lab eval --tracker --out tracker.json --pictures sheets\n"
      "  im2fit-lab eval --tracker --only joints,segmentation --scenes full --subjects 50\n"
      "  im2fit-lab eval --tracker --only guidance --scenes TOO_NEAR,OK --joint-model my.i2t",
      options, run_eval);
  sub->add_option("--subjects", evaluation.subjects, "Held-out people")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  auto* condition = sub->add_option("--condition", options->condition,
                                    "noise: a Kinect in a furnished room; bare: a perfect sensor")
                        ->check(CLI::IsMember({"noise", "bare"}))
                        ->capture_default_str();
  auto* frames = sub->add_option("--frames", evaluation.frames, "Accepted frames behind a measurement")
                     ->check(CLI::Range(5, 1000))
                     ->capture_default_str();
  sub->add_option("--seed", evaluation.seed, "Seed of people and rooms")->capture_default_str();
  sub->add_option("--threads", evaluation.threads, "Threads; the result does not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  auto* samples = sub->add_option("--samples", options->samples, "Samples behind the index (default: INDEX.samples)")
                      ->type_name("DIR");
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--joint-model", options->joint_model, "Tracker file")->type_name("FILE")->capture_default_str();
  auto* index = sub->add_option("--index", options->index, "Index file")->type_name("FILE")->capture_default_str();
  sub->add_option("--out", options->json_path, "Also write the report as JSON")->type_name("FILE");
  sub->add_flag("--json", options->json, "Print the report as JSON");
  add_tracker_words(*sub, options->tracker, {condition, frames, samples, index});
}

}  // namespace im2fit::apps
