// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/site_people.h"
#include "core/file.h"
#include "evaluation/study/calibration_trials.h"
#include "evaluation/study/site_report.h"
#include "person/data_files.h"
#include "train/common/parallel.h"

namespace im2fit::apps {
namespace {

struct SimulateCommand {
  std::string root, site = "simulated site", kind = "plain";
  SimulatedSite simulated;
  std::string body = made_body_path(), joint_model = made_tracker_path(), index = made_index_path();
  std::string ansur = default_ansur_folder();
  std::string calibration, html_path, json_path;
  int trials = 0;
};

struct Models {
  body::BodyModel body;
  Tracker tracker;
  index::Index index;
};

Result<std::shared_ptr<const AnsurPeople>> load_ansur(const SimulateCommand& options, const body::BodyModel& model) {
  auto people = AnsurPeople::load(model, options.ansur, {});
  if (!people) return people.error();
  return std::make_shared<const AnsurPeople>(std::move(*people));
}

Result<std::vector<SimulatedVisit>> simulated(const SimulateCommand& options, const Models& models, SiteKind kind,
                                              const SiteCalibration* calibration) {
  SimulatedSite site = options.simulated;
  site.kind = kind;
  if (kind == SiteKind::people) {
    auto ansur = load_ansur(options, models.body);
    if (!ansur) return ansur.error();
    site.ansur = std::move(*ansur);
  }
  return simulate(models.body, models.tracker.model(), models.index, site, calibration);
}

std::vector<SitePerson> people_of(const std::vector<SimulatedVisit>& visits) {
  std::vector<SitePerson> people;
  for (const SimulatedVisit& visit : visits)
    if (visit.measured) people.push_back(visit.person);
  return people;
}

// All kinds of sites, and one without bias, learned from 10, 20, 40 and 83 of their people.
Result<int> run_trials(const SimulateCommand& options, const Models& models) {
  std::vector<CalibrationTrial> trials;
  const auto add = [&](const std::string& name, const std::vector<SitePerson>& pool) {
    for (const int people : {10, 20, 40, 83})
      if (static_cast<std::size_t>(2 * people) <= pool.size())
        trials.push_back(try_calibrations(name, pool, people, options.trials, options.simulated.seed));
  };
  for (const SiteKind kind : {SiteKind::people, SiteKind::camera, SiteKind::tape, SiteKind::plain}) {
    const auto visits = simulated(options, models, kind, nullptr);
    if (!visits) return visits.error();
    const std::vector<SitePerson> pool = people_of(*visits);
    add(std::string(name_of(kind)), pool);
    if (kind == SiteKind::plain) add("no bias", without_bias(pool));
  }
  if (!options.json_path.empty())
    if (auto ok = write_file_atomically(options.json_path, json_of(trials)); !ok) return ok.error();
  fmt::print("{}", text_of(trials));
  return kExitOk;
}

Result<int> run_sessions(const SimulateCommand& options, const Models& models, SiteKind kind) {
  std::optional<SiteCalibration> calibration;
  if (!options.calibration.empty()) {
    auto loaded = SiteCalibration::load(options.calibration);
    if (!loaded) return loaded.error();
    calibration = std::move(*loaded);
  }
  sessions::Versions versions{IM2FIT_VERSION, "", "", ""};
  for (const auto& [path, name, crc] : {std::tuple(&options.body, kPackedBody, &versions.body),
                                        {&options.joint_model, kPackedTracker, &versions.tracker},
                                        {&options.index, kPackedIndex, &versions.index}}) {
    const auto bytes = model_bytes(*path, name);
    if (!bytes) return bytes.error();
    *crc = sessions::digest_of(*bytes);
  }
  const auto visits = simulated(options, models, kind, calibration ? &*calibration : nullptr);
  if (!visits) return visits.error();
  if (!options.root.empty()) {
    const auto written = write_sessions(options.root, *visits, options.site, versions);
    if (!written) return written.error();
    fmt::print(stderr, "simulate-site: {} sessions of {} people in {}\n", *written, visits->size(), options.root);
  }
  const std::vector<SitePerson> people = people_of(*visits);
  if (people.empty()) return kExitNoMeasurement;
  const SiteStudy study = study_of(people);
  if (!options.json_path.empty())
    if (auto ok = write_file_atomically(options.json_path, json_of(study)); !ok) return ok.error();
  if (!options.html_path.empty())
    if (auto ok = write_file_atomically(options.html_path, html_of(study, people, options.site, true)); !ok)
      return ok.error();
  fmt::print("{}", text_of(study));
  return kExitOk;
}

Result<int> run_simulate(const SimulateCommand& options) {
  auto body = load_body(options.body);
  if (!body) return body.error();
  auto tracker = Tracker::load(options.joint_model);
  if (!tracker) return tracker.error();
  auto index = load_index(options.index);
  if (!index) return index.error();
  const Models models{std::move(*body), std::move(*tracker), std::move(*index)};
  if (options.trials > 0) return run_trials(options, models);
  for (std::size_t i = 0; i < kSiteKindNames.size(); ++i)
    if (options.kind == kSiteKindNames[i]) return run_sessions(options, models, static_cast<SiteKind>(i));
  return Error{ErrorCode::invalid_argument, "no kind '" + options.kind + "'"};
}

}  // namespace

void add_simulate_site(cli::App& app, Command& chosen) {
  auto options = std::make_shared<SimulateCommand>();
  SimulatedSite& site = options->simulated;
  site.threads = default_threads();
  site.progress = show_progress;
  auto* sub = add_command<SimulateCommand>(
      app, chosen, "simulate-site", "Simulate a site with synthetic people and a tape, to try study and calibrate",
      "  im2fit-lab simulate-site --people 83 --kind people --html study.html\n"
      "  im2fit-lab simulate-site DIR --people 20 --kind camera && im2fit-lab calibrate DIR --out site.i2c\n"
      "  im2fit-lab simulate-site --people 83 --kind camera --seed 2 --calibration-site site.i2c\n"
      "  im2fit-lab simulate-site --trials 24 --people 400",
      options, run_simulate);
  auto* root =
      sub->add_option("DIR", options->root, "Folder to write sessions to, without recordings (default: no files)");
  auto* kind =
      sub->add_option("--kind", options->kind,
                      "Difference of the site: people (another body model than in the index), camera (depth 1.5 % "
                      "too large), tape (tight, at the navel, in shoes), plain (no difference)")
          ->one_of({"plain", "people", "camera", "tape"})
          ->capture_default_str();
  sub->add_option("--people", site.people, "Number of people")->range(1, 100000)->capture_default_str();
  sub->add_option("--seed", site.seed, "Seed of people, rooms and tape")->capture_default_str();
  sub->add_option("--frames", site.frames, "Accepted frames for a measurement")
      ->range(1, 1000)
      ->capture_default_str();
  auto* name = sub->add_option("--site", options->site, "Name of the site")->capture_default_str();
  auto* calibration =
      sub->add_option("--calibration-site", options->calibration, "Measure with this site calibration")
          ->type_name("FILE");
  auto* html = sub->add_option("--html", options->html_path, "Write the study of these people as a web page")
                   ->type_name("FILE");
  sub->add_option("--out", options->json_path, "Write the study (or the trials) as JSON")->type_name("FILE");
  auto* trials = sub->add_option("--trials", options->trials,
                                 "Instead of one site: every kind of site, calibrated with 10, 20, 40 and 83 of its "
                                 "people and evaluated with all others, in N draws")
                     ->range(1, 1000);
  for (auto* other : {root, kind, name, calibration, html}) trials->excludes(other);
  sub->add_option("--ansur", options->ansur, "Folder of ANSUR_II_{FEMALE,MALE}_Public.csv, for kind people")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_option("--threads", site.threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--joint-model", options->joint_model, "Tracker file")->type_name("FILE")->capture_default_str();
  sub->add_option("--index", options->index, "Index file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
