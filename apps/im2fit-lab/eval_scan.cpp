// SPDX-License-Identifier: Apache-2.0
// `eval-scan`: people as scans of a booth, measured as `im2fit measure-scan` does.
#include <fmt/core.h>

#include <memory>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"
#include "evaluation/measurements/scan_study.h"
#include "perception/joints/tracker.h"
#include "person/data_files.h"

namespace im2fit::apps {
namespace {

struct EvalScanCommand {
  ScanStudyOptions study;
  std::string body = made_body_path();
  std::string joint_model = made_tracker_path();
  std::string index = made_index_path();
  std::string family = "other";
  std::string ansur = default_ansur_folder();
  std::string other = default_other_folder();
};

Result<int> run_eval_scan(const EvalScanCommand& given) {
  EvalScanCommand options = given;
  const auto family = people_family_of(options.family);
  if (!family) return family.error();
  EvaluationOptions& people = options.study.people;
  people.family = *family;
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto tracker = Tracker::load(options.joint_model);
  if (!tracker) return tracker.error();
  const auto index = load_index(options.index);
  if (!index) return index.error();
  if (*family == PeopleFamily::ansur || *family == PeopleFamily::mixed) {
    auto loaded = AnsurPeople::load(*model, options.ansur, {});
    if (!loaded) return loaded.error();
    people.ansur = std::make_shared<AnsurPeople>(std::move(*loaded));
  }
  if (*family == PeopleFamily::other) {
    auto loaded = OtherPeople::load(options.other, options.ansur, {});
    if (!loaded) return loaded.error();
    people.other = std::make_shared<OtherPeople>(std::move(*loaded));
  }
  const auto outcomes = study_scans(*model, tracker->model(), *index, options.study);
  if (!outcomes) return outcomes.error();
  fmt::print("{}", text_of(*outcomes));
  return kExitOk;
}

}  // namespace

void add_eval_scan(cli::App& app, Command& chosen) {
  auto options = std::make_shared<EvalScanCommand>();
  auto& people = options->study.people;
  people.subjects = 10;
  people.noise = false;
  people.pose = StandingPose::arms_out;
  people.threads = default_threads();
  people.progress = show_progress;
  auto* sub = add_command<EvalScanCommand>(
      app, chosen, "eval-scan", "Measure scans of simulated people, and compare with the true values",
      "  im2fit-lab eval-scan --family other\n"
      "  im2fit-lab eval-scan --family modifiers --noise-mm 0 --holes 0 --keep scans",
      options, run_eval_scan);
  sub->add_option("--subjects", people.subjects, "Held-out people")->range(1, 100000)->capture_default_str();
  sub->add_option("--seed", people.seed, "Seed of people, noise and holes")->capture_default_str();
  sub->add_option("--threads", people.threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option("--family", options->family, "People to measure: modifiers, ansur or other")
      ->check([](const std::string& name) {
        const auto known = people_family_of(name);
        return known ? "" : known.error().message;
      })
      ->capture_default_str();
  sub->add_option("--noise-mm", options->study.noise_mm, "Noise of each vertex along its normal, standard deviation")
      ->range(0.0F, 20.0F)
      ->capture_default_str();
  sub->add_option("--holes", options->study.holes, "Holes of 25 to 50 mm radius")
      ->range(0, 100)
      ->capture_default_str();
  sub->add_option("--keep", options->study.keep_folder, "Keep the scans in this folder")->type_name("DIR");
  sub->add_option("--ansur", options->ansur, "Folder of ANSUR_II_{FEMALE,MALE}_Public.csv")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_option("--other", options->other, "Folder of s-scape_male.obj")->type_name("DIR")->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--joint-model", options->joint_model, "Tracker file")->type_name("FILE")->capture_default_str();
  sub->add_option("--index", options->index, "Index file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
