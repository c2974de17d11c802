// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/eval_tracker.h"
#include "apps/im2fit-lab/samples.h"
#include "core/file.h"
#include "evaluation/measurements/full_report.h"
#include "index/format.h"
#include "person/data_files.h"
#include "train/common/parallel.h"
#include "train/dataset/dataset.h"

namespace im2fit::apps {
namespace {

struct EvalCommand {
  EvaluationOptions evaluation;
  std::string condition = "noise";
  std::vector<std::string> conditions;
  std::string body = made_body_path();
  std::string joint_model = made_tracker_path();
  std::string index = made_index_path();
  std::string samples;
  std::vector<std::string> families = {"modifiers"};
  std::string ansur = default_ansur_folder();
  std::string other = default_other_folder();
  AnsurSettings ansur_settings;
  std::string commit;
  std::string json_path, html_path, csv_path, people_path, figures_path;
  std::vector<std::string> runtime_indexes;
  std::string runtime_references, icp_references;
  TrackerEvalWords tracker;
  int icp_people = 0;
  bool all = false, no_raw = false, runtime = false, json = false;

  bool full() const {
    return all || !conditions.empty() || families.size() > 1 || !html_path.empty() || !figures_path.empty() ||
           runtime || !runtime_indexes.empty() || !runtime_references.empty() || icp_people > 0 ||
           !icp_references.empty();
  }
};

// The samples behind the index, for the paper's nearest neighbour. Absent shards leave that column empty.
Result<std::optional<index::RawNearest>> load_raw(const EvalCommand& options) {
  if (options.no_raw) return std::optional<index::RawNearest>{};
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

Result<std::vector<Condition>> wanted_conditions(const EvalCommand& options) {
  std::vector<std::string> names = {options.condition};
  if (!options.conditions.empty()) names = options.conditions;
  if (options.all) names = all_conditions();
  std::vector<Condition> conditions;
  for (const std::string& name : names) {
    auto condition = condition_of(name, options.evaluation);
    if (!condition) return condition.error();
    conditions.push_back(std::move(*condition));
  }
  return conditions;
}

// The survey is read, and mean bodies made, only where they are needed.
struct Families {
  std::shared_ptr<const AnsurPeople> ansur;
  std::shared_ptr<const OtherPeople> other;
};
Result<Families> load_families(const EvalCommand& options, const body::BodyModel& model) {
  const auto wanted = [&](PeopleFamily family) {
    return std::find(options.families.begin(), options.families.end(), name_of(family)) != options.families.end();
  };
  Families families;
  if (wanted(PeopleFamily::ansur) || wanted(PeopleFamily::mixed)) {
    auto people = AnsurPeople::load(model, options.ansur, options.ansur_settings);
    if (!people) return people.error();
    families.ansur = std::make_shared<AnsurPeople>(std::move(*people));
  }
  if (wanted(PeopleFamily::other)) {
    auto people = OtherPeople::load(options.other, options.ansur, options.ansur_settings);
    if (!people) return people.error();
    families.other = std::make_shared<OtherPeople>(std::move(*people));
  }
  return families;
}

// Of each family: before anybody is measured.
Status check_families(const EvalCommand& options, const std::vector<Condition>& conditions) {
  for (const std::string& name : options.families) {
    const auto family = people_family_of(name);
    if (!family) return family.error();
    for (Condition condition : conditions) {
      condition.options.family = *family;
      if (auto shown = shown_by_family(condition); !shown) return shown;
    }
  }
  return Ok{};
}

// One condition with every family, the worse first.
Result<std::vector<ConditionRun>> run_condition(const EvalCommand& options, const Condition& condition,
                                                const SessionModels& models, const index::RawNearest* raw,
                                                const Families& families) {
  std::vector<ConditionRun> runs;
  for (const std::string& name : options.families) {
    Condition of_family = condition;
    const auto family = people_family_of(name);
    if (!family) return family.error();
    of_family.options.family = *family;
    of_family.options.ansur = families.ansur;
    of_family.options.other = families.other;
    auto outcomes =
        evaluate(models.body, models.joints, models.index, raw, of_family.options, condition.name + " of " + name);
    if (!outcomes) return outcomes.error();
    ConditionRun run{of_family, std::move(*outcomes), {}};
    run.report = report_of(run.outcomes, condition.name, condition.what, name);
    run.report.with = {dataset_version_in(models.index.info().provenance), index::kVersion, models.index.size(),
                       options.evaluation.seed, options.commit};
    runs.push_back(std::move(run));
  }
  std::stable_sort(runs.begin(), runs.end(), [](const ConditionRun& a, const ConditionRun& b) {
    return girth_error_mm(a.report) > girth_error_mm(b.report);
  });
  return runs;
}

Status add_machine_figures(const EvalCommand& options, const SessionModels& models, FullReport& report) {
  const EvaluationOptions& seen = report.runs.front().condition.options;
  if (options.runtime || !options.runtime_indexes.empty()) {
    auto rows = measure_runtime(models, options.index, options.runtime_indexes, seen);
    if (!rows) return rows.error();
    report.runtime = std::move(*rows);
  }
  if (!options.runtime_references.empty()) {
    auto references = read_index_references(options.runtime_references);
    if (!references) return references.error();
    report.references = std::move(*references);
  }
  if (!options.icp_references.empty()) {
    auto curves = read_icp_curves(options.icp_references);
    if (!curves) return curves.error();
    report.icp = std::move(*curves);
  } else if (options.icp_people > 0) {
    const auto cases = icp_cases(models, seen, options.icp_people);
    if (!cases) return cases.error();
    report.icp = icp_curves(models.body, *cases);
  }
  return Ok{};
}

Status write_outputs(const EvalCommand& options, const FullReport& report) {
  const std::pair<const std::string&, std::string> files[] = {
      {options.json_path, options.full() ? json_of(report) : json_of(report.runs.front().report)},
      {options.csv_path, csv_of(report.runs)},
      {options.people_path, options.people_path.empty() ? "" : people_csv_of(report.runs)},
      {options.html_path, options.html_path.empty() ? "" : html_of(report)}};
  for (const auto& [path, text] : files)
    if (!path.empty())
      if (auto written = write_file_atomically(path, text); !written) return written;
  if (options.figures_path.empty()) return Ok{};
  if (auto made = make_directory(options.figures_path); !made) return made;
  for (const Figure& figure : figures_of(report))
    if (auto written = write_file_atomically(options.figures_path + "/" + figure.id + ".svg", figure.picture.file());
        !written)
      return written;
  return Ok{};
}

Result<int> run_eval(const EvalCommand& options) {
  const auto conditions = wanted_conditions(options);
  if (!conditions) return conditions.error();
  if (const auto shown = check_families(options, *conditions); !shown) return shown.error();
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

  FullReport report;
  report.provenance =
      fmt::format("seed {}, {} people a condition, index of {} models in {} dimensions: {}", options.evaluation.seed,
                  options.evaluation.subjects, index->size(), index->dimensions(), index->info().provenance);
  const SessionModels models{*model, tracker->model(), *index, &model->shape_space()};
  const auto families = load_families(options, *model);
  if (!families) return families.error();
  for (const Condition& condition : *conditions) {
    auto runs = run_condition(options, condition, models, raw->has_value() ? &**raw : nullptr, *families);
    if (!runs) return runs.error();
    for (ConditionRun& run : *runs) {
      if (!options.json) fmt::print("{}{}", report.runs.empty() ? "" : "\n", text_of(run.report));
      report.runs.push_back(std::move(run));
    }
  }
  if (const auto added = add_machine_figures(options, models, report); !added) return added.error();
  if (const auto written = write_outputs(options, report); !written) return written.error();
  if (options.json) fmt::print("{}", options.full() ? json_of(report) : json_of(report.runs.front().report));
  if (!options.json && report.runs.size() > 1) fmt::print("\n{}", text_of(report.runs));
  return kExitOk;
}

// Everything that has no meaning beside --tracker.
std::vector<cli::Option*> add_measuring_options(cli::App& sub, EvalCommand& o) {
  auto* condition =
      sub.add_option("--condition", o.condition, "One condition, one or more words joined by +: " + condition_help())
          ->check([](const std::string& name) {
            const auto known = condition_of(name, {});
            return known ? "" : known.error().message;
          })
          ->capture_default_str();
  auto* conditions = sub.add_option("--conditions", o.conditions, "Several conditions, separated by commas")
                         ->delimiter(',')
                         ->check([](const std::string& name) {
                           const auto known = condition_of(name, {});
                           return known ? "" : known.error().message;
                         })
                         ->excludes(condition);
  auto* all =
      sub.add_flag("--all", o.all, "All conditions, one after another")->excludes(condition)->excludes(conditions);
  auto* family =
      sub.add_option(
             "--family", o.families,
             "People to measure: modifiers (held-out people of the body model), ansur (dimensions from a "
             "survey, made by another method), mixed (both in alternation), other (men with dimensions from a "
             "survey, another mesh and rig, no clothes); several, separated by commas; the one with the "
             "larger error is shown first")
          ->delimiter(',')
          ->check([](const std::string& name) {
            const auto known = people_family_of(name);
            return known ? "" : known.error().message;
          });
  auto* ansur = sub.add_option("--ansur", o.ansur, "Folder of ANSUR_II_{FEMALE,MALE}_Public.csv, for those families")
                    ->type_name("DIR")
                    ->capture_default_str();
  auto* other = sub.add_option("--other", o.other, "Folder of s-scape_male.obj, for the family other")
                    ->type_name("DIR")
                    ->capture_default_str();
  auto* ends = sub.add_option("--ansur-ends", o.ansur_settings.end_share,
                              "Share of people of ansur that are changed to a BMI of 17 to 19 or 32 to 42, which is "
                              "rare in the survey")
                   ->range(0.0, 1.0)
                   ->capture_default_str();
  auto* pressed = sub.add_option("--ansur-pressed", o.ansur_settings.pressed_share,
                                 "The measured girth exceeds the ellipse of breadth and depth: share of this excess "
                                 "caused by the pressure of the callipers")
                      ->range(0.0, 1.0)
                      ->capture_default_str();
  auto* square = sub.add_option("--ansur-square", o.ansur_settings.square_share,
                                "Share of this excess caused by sections that are squarer than ellipses; the "
                                "bodies of ansur do not have the rest")
                     ->range(0.0, 1.0)
                     ->capture_default_str();
  auto* frames = sub.add_option("--frames", o.evaluation.frames, "Accepted frames for a measurement")
                     ->range(1, 1000)
                     ->capture_default_str();
  auto* scale = sub.add_option("--camera-scale", o.evaluation.camera_scale,
                               "Scale error of the camera's depth: with 1.01 people appear 1 % larger")
                    ->range(0.9F, 1.1F)
                    ->capture_default_str();
  auto* twice = sub.add_flag("--twice", o.evaluation.twice,
                             "Render each person again with another pose, room and noise, for repeatability (TEM)");
  auto* second_waist = sub.add_option("--second-waist", o.evaluation.second_waist_mm,
                                      "With --twice: increase of the waist in the second capture, mm; see `again` of "
                                      "--people. Not for `other`")
                           ->range(-200.0F, 200.0F)
                           ->needs(twice);
  auto* samples =
      sub.add_option("--samples", o.samples, "Samples of the index (default: INDEX.samples)")->type_name("DIR");
  auto* no_raw =
      sub.add_flag("--no-raw", o.no_raw, "Leave out the paper's nearest neighbour, which takes half of the time");
  auto* index = sub.add_option("--index", o.index, "Index file")->type_name("FILE")->capture_default_str();
  auto* html =
      sub.add_option("--html", o.html_path, "Write the report as a web page with figures")->type_name("FILE");
  auto* commit = sub.add_option("--commit", o.commit, "Commit of the sources of this program, written to the JSON")
                     ->type_name("TEXT");
  auto* csv =
      sub.add_option("--csv", o.csv_path, "Write all values as CSV, with a row for each condition and measurement")
          ->type_name("FILE");
  auto* people =
      sub.add_option("--people", o.people_path, "Write the measurements of each person as CSV")->type_name("FILE");
  auto* figures = sub.add_option("--figures", o.figures_path, "Write each figure as SVG")->type_name("DIR");
  auto* runtime =
      sub.add_flag("--runtime", o.runtime, "Measure the time of index queries, for the paper's runtime figure");
  auto* indexes =
      sub.add_option("--runtime-index", o.runtime_indexes, "The same for further indexes")->type_name("FILE");
  auto* runtime_references = sub.add_option("--runtime-references", o.runtime_references,
                                            "Other libraries in the figure: bench/results/index-references.json")
                                 ->type_name("FILE");
  auto* icp =
      sub.add_option("--icp", o.icp_people, "Register the depth of N people with their body by ICP")->range(1, 100);
  auto* icp_references =
      sub.add_option("--icp-references", o.icp_references,
                     "Instead of --icp: the output of `references_bench icp`, which compares with PCL")
          ->type_name("FILE")
          ->excludes(icp);
  return {condition, conditions,    all,   family, ansur,        other,   ends,    pressed,
          square,    frames,        scale, twice,  second_waist, samples, no_raw,  index,
          html,      commit,        csv,   people, figures,      runtime, indexes, runtime_references,
          icp,       icp_references};
}

}  // namespace

void add_eval(cli::App& app, Command& chosen) {
  auto options = std::make_shared<EvalCommand>();
  auto& evaluation = options->evaluation;
  evaluation.threads = default_threads();
  evaluation.progress = show_progress;
  auto* sub = add_command<EvalCommand>(
      app, chosen, "eval",
      "Measure held-out synthetic people and compare with the true values; or evaluate the tracker",
      "  im2fit-lab eval --subjects 200 --condition noise\n"
      "  im2fit-lab eval --subjects 40 --condition bare --out eval.json\n"
      "  im2fit-lab eval --all --twice --html eval.html --runtime --icp 4\n"
      "  im2fit-lab eval --family ansur,modifiers --conditions noise,both --subjects 100\n"
      "  im2fit-lab eval --conditions noise,clothed,clothed+320 --csv eval.csv\n"
      "  im2fit-lab eval --tracker --out tracker.json --pictures sheets\n"
      "  im2fit-lab eval --tracker --only joints,segmentation --scenes full --subjects 50\n"
      "  im2fit-lab eval --tracker --only guidance --scenes TOO_NEAR,OK --joint-model my.i2t",
      options, run_eval);
  sub->add_option("--subjects", evaluation.subjects, "Held-out people")->range(1, 100000)->capture_default_str();
  sub->add_option("--seed", evaluation.seed, "Seed of people and rooms")->capture_default_str();
  sub->add_option("--threads", evaluation.threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--joint-model", options->joint_model, "Tracker file")->type_name("FILE")->capture_default_str();
  sub->add_option("--out", options->json_path, "Also write the report as JSON")->type_name("FILE");
  sub->add_flag("--json", options->json, "Print the report as JSON");
  add_tracker_words(*sub, options->tracker, add_measuring_options(*sub, *options));
}

}  // namespace im2fit::apps
