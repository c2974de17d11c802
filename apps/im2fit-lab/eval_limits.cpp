// SPDX-License-Identifier: Apache-2.0
// `eval-limits`: people in situations in which an answer may be wrong.
#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"
#include "core/file.h"
#include "evaluation/measurements/limits_study.h"
#include "formats/plain_png.h"

namespace im2fit::apps {
namespace {

struct EvalLimitsCommand {
  EvaluationOptions people;
  std::vector<std::string> situations;
  std::string body = made_body_path();
  std::string joint_model = made_tracker_path();
  std::string index = made_index_path();
  std::string family = "mixed";
  std::string ansur = default_ansur_folder();
  std::string other = default_other_folder();
  std::string people_path, pictures_path;
  bool perfect = false;
};

Result<std::vector<Situation>> wanted_situations(const std::vector<std::string>& words, const std::string& family) {
  std::vector<Situation> out;
  for (const std::string& word : words) {
    const auto situation = situation_of(word);
    if (!situation) return situation.error();
    if (family == "other" && rule_of(*situation).of_model_mesh)
      return Error{ErrorCode::invalid_argument,
                   "people of the family other cannot be shown in the situation " + word + "; choose another family"};
    out.push_back(*situation);
  }
  for (std::size_t s = 0; words.empty() && s < kSituationCount; ++s) out.push_back(static_cast<Situation>(s));
  return out;
}

Status load_family(const EvalLimitsCommand& options, const body::BodyModel& model, EvaluationOptions& people) {
  const auto family = people_family_of(options.family);
  if (!family) return family.error();
  people.family = *family;
  if (*family == PeopleFamily::ansur || *family == PeopleFamily::mixed) {
    auto made = AnsurPeople::load(model, options.ansur, {});
    if (!made) return made.error();
    people.ansur = std::make_shared<AnsurPeople>(std::move(*made));
  }
  if (*family == PeopleFamily::other) {
    auto made = OtherPeople::load(options.other, options.ansur, {});
    if (!made) return made.error();
    people.other = std::make_shared<OtherPeople>(std::move(*made));
  }
  return Ok{};
}

// Nearer is brighter, and edges of slopes are drawn out.
Result<std::vector<std::byte>> shaded(const ShownPicture& picture) {
  constexpr float kNearMm = 1000, kFarMm = 5000, kSlopeGain = 4;
  const DepthView depth(picture.depth_mm.data(), picture.width, picture.height);
  std::vector<std::uint8_t> grey;
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      const auto mm = static_cast<float>(depth.at(u, v));
      const auto above = static_cast<float>(depth.at(u, std::max(0, v - 2)));
      const float slope = std::clamp(kSlopeGain * (above - mm), -60.0F, 60.0F);
      const float value = mm == 0 ? 0 : 60 + 130 * (kFarMm - mm) / (kFarMm - kNearMm) + slope;
      grey.insert(grey.end(), 3, static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F)));
    }
  return hal::encode_rgb_png(picture.width, picture.height, grey);
}

// SITUATION-N.png of every person.
Status write_shown(const std::string& folder, const body::BodyModel& model, const EvaluationOptions& people,
                   const std::vector<Situation>& situations) {
  if (auto made = make_directory(folder); !made) return made;
  for (const Situation situation : situations) {
    if (people.family == PeopleFamily::other && rule_of(situation).of_model_mesh) continue;
    for (int i = 0; i < people.subjects; ++i) {
      const auto person = person_in(model, people, situation, static_cast<std::uint64_t>(i));
      const auto png = shaded(first_picture(model, person));
      if (!png) return png.error();
      const std::string path = fmt::format("{}/{}-{}.png", folder, rule_of(situation).id, i);
      if (auto written = write_file_atomically(path, *png); !written) return written;
    }
  }
  return Ok{};
}

Result<int> run_eval_limits(const EvalLimitsCommand& options) {
  const auto situations = wanted_situations(options.situations, options.family);
  if (!situations) return situations.error();
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto tracker = Tracker::load(options.joint_model);
  if (!tracker) return tracker.error();
  const auto index = load_index(options.index);
  if (!index) return index.error();
  EvaluationOptions people = options.people;
  people.noise = !options.perfect;
  if (auto loaded = load_family(options, *model, people); !loaded) return loaded.error();
  if (!options.pictures_path.empty())
    if (auto written = write_shown(options.pictures_path, *model, people, *situations); !written)
      return written.error();
  const SessionModels models{*model, tracker->model(), *index, &model->shape_space()};
  const auto outcomes = study_limits(models, people, *situations);
  if (!outcomes) return outcomes.error();
  fmt::print("{}", text_of(*outcomes));
  if (!options.people_path.empty())
    if (auto written = write_file_atomically(options.people_path, csv_of(*outcomes)); !written)
      return written.error();
  return kExitOk;
}

std::string situation_help() {
  std::string text = "Only these, separated by commas: ";
  for (std::size_t s = 0; s < kSituationCount; ++s) {
    const SituationRule& rule = rule_of(static_cast<Situation>(s));
    text += fmt::format("{}{} ({})", s == 0 ? "" : ", ", rule.id, rule.what);
  }
  return text;
}

}  // namespace

void add_eval_limits(cli::App& app, Command& chosen) {
  auto options = std::make_shared<EvalLimitsCommand>();
  auto& people = options->people;
  people.subjects = 25;
  people.clothing_reported = false;
  people.threads = default_threads();
  people.progress = show_progress;
  auto* sub = add_command<EvalLimitsCommand>(
      app, chosen, "eval-limits",
      "Show simulated people in situations in which an answer may be wrong, and count who is refused by name or "
      "right",
      "  im2fit-lab eval-limits --subjects 100\n"
      "  im2fit-lab eval-limits --situations child,hem --family modifiers --people limits.csv",
      options, run_eval_limits);
  sub->add_option("--subjects", people.subjects, "Held-out people a situation")
      ->range(1, 100000)
      ->capture_default_str();
  sub->add_option("--situations", options->situations, situation_help())
      ->delimiter(',')
      ->check([](const std::string& name) {
        const auto known = situation_of(name);
        return known ? "" : known.error().message;
      });
  sub->add_option("--seed", people.seed, "Seed of people, rooms and situations")->capture_default_str();
  sub->add_option("--threads", people.threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option(
         "--family", options->family,
         "People to measure: modifiers, ansur, mixed (both in turns) or other (without heels, hem and dressed)")
      ->check([](const std::string& name) {
        const auto known = people_family_of(name);
        return known ? "" : known.error().message;
      })
      ->capture_default_str();
  sub->add_flag("--perfect", options->perfect, "A perfect sensor in an empty room");
  sub->add_option("--ansur", options->ansur, "Folder of ANSUR_II_{FEMALE,MALE}_Public.csv")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_option("--other", options->other, "Folder of s-scape_male.obj")->type_name("DIR")->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--joint-model", options->joint_model, "Tracker file")->type_name("FILE")->capture_default_str();
  sub->add_option("--index", options->index, "Index file")->type_name("FILE")->capture_default_str();
  sub->add_option("--pictures", options->pictures_path, "Write the first picture of each person as PNG")
      ->type_name("DIR");
  sub->add_option("--people", options->people_path, "Write each person as CSV")->type_name("FILE");
}

}  // namespace im2fit::apps
