// SPDX-License-Identifier: Apache-2.0
// `eval-turn`: people who turn round once, measured from all sides.
#include <fmt/core.h>

#include <memory>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"
#include "body/fit/point_mesh.h"
#include "body/fit/turn_fitter.h"
#include "core/file.h"
#include "evaluation/measurements/turn_study.h"
#include "perception/joints/tracker.h"

namespace im2fit::apps {
namespace {

struct EvalTurnCommand {
  TurnStudyOptions study;
  std::string body = made_body_path();
  std::string joint_model = made_tracker_path();
  std::string family = "other";
  std::string ansur = default_ansur_folder();
  std::string other = default_other_folder();
  std::string people_path;
  bool perfect = false;
};

std::string people_csv(const std::vector<TurnOutcome>& outcomes) {
  std::string text = "person,woman,measured,turned_deg,true_turn_deg,yaw_error_deg,frames,frames_followed,surface_mm";
  for (const auto& m : kMeasurementTable) text += fmt::format(",{0},true_{0}", m.id);
  for (const char* limb : kTurnLimbs) text += fmt::format(",{0},true_{0},answered_{0}", limb);
  for (const char* level : {"chest", "waist", "hip"})
    text += fmt::format(",{0}_height_error,{0}_at_true_height", level);
  text += "\n";
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const TurnOutcome& o = outcomes[i];
    text += fmt::format("{},{},{},{:.1f},{:.1f},{:.2f},{},{},{:.2f}", i, o.woman ? 1 : 0, o.measured ? 1 : 0,
                        o.turned_deg, o.true_turn_deg, o.yaw_error_deg, o.frames, o.frames_followed, o.surface_mm);
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      text += fmt::format(",{:.1f},{:.1f}", o.measured_values[m], o.truth[m]);
    for (std::size_t l = 0; l < kTurnLimbCount; ++l)
      text += fmt::format(",{:.1f},{:.1f},{:.1f}", o.fused_limbs[l], o.true_limbs[l], o.answered_limbs[l]);
    for (std::size_t l = 0; l < o.level_error_mm.size(); ++l)
      text += o.has_levels ? fmt::format(",{:.1f},{:.1f}", o.level_error_mm[l], o.at_true_level_mm[l]) : ",,";
    text += "\n";
  }
  return text;
}

Result<int> run_eval_turn(const EvalTurnCommand& given) {
  EvalTurnCommand options = given;
  const auto family = people_family_of(options.family);
  if (!family) return family.error();
  options.study.people.family = *family;
  options.study.people.noise = !options.perfect;
  const auto model = load_body(options.body);
  if (!model) return model.error();
  if (!body::PointMesh(*model).valid())
    return Error{ErrorCode::invalid_argument,
                 options.body + ": has no shape space of its own mesh; im2fit-lab fetch adds it"};
  const auto tracker = Tracker::load(options.joint_model);
  if (!tracker) return tracker.error();
  if (*family == PeopleFamily::ansur || *family == PeopleFamily::mixed) {
    auto people = AnsurPeople::load(*model, options.ansur, {});
    if (!people) return people.error();
    options.study.people.ansur = std::make_shared<AnsurPeople>(std::move(*people));
  }
  if (*family == PeopleFamily::other) {
    auto people = OtherPeople::load(options.other, options.ansur, {});
    if (!people) return people.error();
    options.study.people.other = std::make_shared<OtherPeople>(std::move(*people));
  }
  const auto outcomes = study_turns(*model, tracker->model(), options.study);
  if (!outcomes) return outcomes.error();
  fmt::print("{}", text_of(*outcomes));
  if (!options.people_path.empty())
    if (auto written = write_file_atomically(options.people_path, people_csv(*outcomes)); !written)
      return written.error();
  return kExitOk;
}

}  // namespace

void add_eval_turn(cli::App& app, Command& chosen) {
  auto options = std::make_shared<EvalTurnCommand>();
  auto& people = options->study.people;
  people.subjects = 40;
  people.pose = StandingPose::arms_out;
  people.threads = default_threads();
  people.progress = show_progress;
  auto* sub = add_command<EvalTurnCommand>(
      app, chosen, "eval-turn", "Measure simulated people who make one full turn, and compare with the true values",
      "  im2fit-lab eval-turn --family other --subjects 40\n"
      "  im2fit-lab eval-turn --family ansur --degrees 180 --views 5 --people turn.csv",
      options, run_eval_turn);
  sub->add_option("--subjects", people.subjects, "Held-out people")->range(1, 100000)->capture_default_str();
  sub->add_option("--seed", people.seed, "Seed of people and rooms")->capture_default_str();
  sub->add_option("--threads", people.threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option("--family", options->family, "People to measure: modifiers, ansur or other")
      ->check([](const std::string& name) {
        const auto known = people_family_of(name);
        return known ? "" : known.error().message;
      })
      ->capture_default_str();
  sub->add_option("--degrees", options->study.degrees, "Angle of the turn")
      ->range(30.0F, 360.0F)
      ->capture_default_str();
  sub->add_option("--views", options->study.view_count, "Pictures that are fitted together")
      ->range(1, static_cast<int>(body::kTurnViewMax))
      ->capture_default_str();
  sub->add_flag("--perfect", options->perfect, "A perfect sensor in an empty room");
  sub->add_option("--ansur", options->ansur, "Folder of ANSUR_II_{FEMALE,MALE}_Public.csv")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_option("--other", options->other, "Folder of s-scape_male.obj")->type_name("DIR")->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--joint-model", options->joint_model, "Tracker file")->type_name("FILE")->capture_default_str();
  sub->add_option("--people", options->people_path, "Write each person as CSV")->type_name("FILE");
}

}  // namespace im2fit::apps
