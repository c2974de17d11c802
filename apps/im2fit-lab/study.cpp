// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <memory>
#include <string>

#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/site_people.h"
#include "core/file.h"
#include "core/text.h"
#include "evaluation/study/calibrate.h"
#include "evaluation/study/site_report.h"

namespace im2fit::apps {
namespace {

struct StudyCommand {
  std::string root = sessions::default_root();
  std::string html_path, json_path;
  bool json = false;
};

struct CalibrateCommand {
  std::string root = sessions::default_root();
  std::string out, name, json_path;
  bool json = false;
};

void tell_left_out(const char* command, const SitePeople& all) {
  for (const std::string& why : all.left_out) fmt::print(stderr, "{}: left out {}\n", command, printable(why));
}

Result<int> run_study(const StudyCommand& options) {
  const auto all = site_people(options.root);
  if (!all) return all.error();
  tell_left_out("study", *all);
  const SiteStudy study = study_of(all->people);
  if (study.people == 0) return Error{ErrorCode::not_found, options.root + ": no session has a measured person"};
  const std::string json = json_of(study);
  // No names, but what people measure: the owner's alone.
  if (!options.json_path.empty())
    if (auto ok = write_file_atomically(options.json_path, json, Readable::by_owner); !ok) return ok.error();
  if (!options.html_path.empty()) {
    const std::string title = all->site.empty() ? "A site and its tape" : all->site;
    if (auto ok = write_file_atomically(options.html_path, html_of(study, all->people, title, all->synthetic),
                                        Readable::by_owner);
        !ok)
      return ok.error();
  }
  fmt::print("{}", options.json ? json : text_of(study));
  return kExitOk;
}

Result<int> run_calibrate(const CalibrateCommand& options) {
  const auto all = site_people(options.root);
  if (!all) return all.error();
  tell_left_out("calibrate", *all);
  if (all->indexes.size() > 1)
    return Error{ErrorCode::invalid_argument, options.root + ": sessions were measured with " +
                                                  std::to_string(all->indexes.size()) +
                                                  " different indexes; measure their recordings again with one"};
  const CalibrationOutcome outcome = calibrate(all->people);
  const std::string json = json_of(outcome);
  if (!options.json_path.empty())
    if (auto ok = write_file_atomically(options.json_path, json, Readable::by_owner); !ok) return ok.error();
  fmt::print("{}", options.json ? json : text_of(outcome));
  if (!outcome.refusal.empty()) return kExitFailed;
  std::string name = options.name.empty() ? all->site : options.name;
  if (name.empty()) name = "site";
  std::uint32_t index_crc = 0;
  if (!all->indexes.empty()) index_crc = static_cast<std::uint32_t>(std::stoul(all->indexes.front(), nullptr, 16));
  const auto file = site_calibration(outcome, name, index_crc).file();
  if (!file) return file.error();
  if (auto ok = write_file_atomically(options.out, *file); !ok) return ok.error();
  fmt::print(stderr, "calibrate: {}: {} bytes, of {} people; use it with --calibration-site\n", options.out,
             file->size(), outcome.people);
  return kExitOk;
}

}  // namespace

void add_study(cli::App& app, Command& chosen) {
  auto options = std::make_shared<StudyCommand>();
  auto* sub = add_command<StudyCommand>(app, chosen, "study",
                                        "Compare measurements with tape values for the people of recorded sessions",
                                        "  im2fit-lab study ~/sessions --html study.html\n"
                                        "  im2fit-lab study ~/sessions --json",
                                        options, run_study);
  sub->add_option("DIR", options->root, "Folder of sessions (docs/sessions.md)")->capture_default_str();
  sub->add_option("--html", options->html_path, "Write the report as a web page with figures")->type_name("FILE");
  sub->add_option("--out", options->json_path, "Also write the report as JSON")->type_name("FILE");
  sub->add_flag("--json", options->json, "Print the report as JSON");
}

void add_calibrate(cli::App& app, Command& chosen) {
  auto options = std::make_shared<CalibrateCommand>();
  auto* sub = add_command<CalibrateCommand>(
      app, chosen, "calibrate",
      "Learn a correction of a site's measurements from its sessions; exit 1 without a file if it does not help",
      "  im2fit-lab calibrate ~/sessions --out shop.i2c\n"
      "  im2fit measure SOURCE --calibration-site shop.i2c",
      options, run_calibrate);
  sub->add_option("DIR", options->root, "Folder of sessions (docs/sessions.md)")->capture_default_str();
  sub->add_option("--out", options->out, "Calibration to write, .i2c")->required()->type_name("FILE");
  sub->add_option("--name", options->name, "Name of the site, written to results (default: from the sessions)");
  sub->add_option("--report", options->json_path, "Also write the outcome as JSON")->type_name("FILE");
  sub->add_flag("--json", options->json, "Print the outcome as JSON");
}

}  // namespace im2fit::apps
