// SPDX-License-Identifier: Apache-2.0
// im2fit sessions list | show | measure | replay | delete.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/common/progress.h"
#include "apps/im2fit/commands.h"
#include "apps/im2fit/live_run.h"
#include "apps/im2fit/remeasure.h"
#include "apps/sessions/store.h"
#include "core/text.h"
#include "formats/json_file.h"
#include "report/text_table.h"

namespace im2fit::apps {
namespace {

struct SessionsOptions {
  RemeasureOptions session;
  bool json = false;
};

std::string or_dash(const std::string& text) {
  return text.empty() ? "-" : text;
}

// A terminal obeys DEL and U+0080 to U+009F, which JSON has as they are, and only within texts: there an escape is
// the same character.
std::string for_terminal(const std::string& json) {
  std::string out;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const auto c = static_cast<unsigned char>(json[i]);
    const auto next = i + 1 < json.size() ? static_cast<unsigned char>(json[i + 1]) : 0U;
    if (c == 0x7F) {
      out += "\\u007f";
    } else if (c == 0xC2 && next >= 0x80 && next < 0xA0) {
      out += fmt::format("\\u{:04x}", next);
      ++i;
    } else {
      out += json[i];
    }
  }
  return out;
}

Result<int> run_list(const SessionsOptions& options) {
  const auto all = sessions::list(options.session.root);
  if (!all) return all.error();
  if (options.json) {
    Json json = Json::array();
    for (const sessions::Listed& one : *all) {
      Json entry = {{"id", one.id}};
      if (!one.damage.empty())
        entry["damage"] = one.damage;
      else
        entry.update(*parse_json<Json>(one.record.document, one.id));
      json.push_back(std::move(entry));
    }
    fmt::print("{}\n", for_terminal(json_text(json, 1)));
    return kExitOk;
  }
  TextTable table({"id", "person", "height", "clothing", "tape values", "site"});
  for (const sessions::Listed& one : *all) {
    if (!one.damage.empty()) {
      print_error(one.damage);
      continue;
    }
    const sessions::PersonTruth& truth = one.record.truth;
    table.add({one.id, one.record.person, number(truth.height_mm.value_or(std::nan(""))), or_dash(truth.clothing),
               std::to_string(truth.tape.size()), or_dash(one.record.site)});
  }
  if (all->empty())
    fmt::print("no sessions in {}\n", printable(options.session.root));
  else
    fmt::print("{}", table.text());
  return kExitOk;
}

void print_field(const char* name, const std::string& value) {
  if (!value.empty()) fmt::print("{:<11} {}\n", name, printable(value));
}

void print_truth(const sessions::PersonTruth& truth) {
  if (truth.height_mm) print_field("height", number(*truth.height_mm) + " mm");
  if (truth.weight_kg) print_field("weight", number(*truth.weight_kg, 1) + " kg");
  if (truth.age_years) print_field("age", number(*truth.age_years));
  print_field("gender", truth.gender);
  print_field("worn size", truth.worn_size);
  print_field("clothing", truth.clothing);
  if (truth.tape.empty()) return;
  TextTable table({"tape, mm", "first", "second"});
  for (const auto& [id, reading] : truth.tape)
    table.add({id, number(reading.first), number(reading.second.value_or(std::nan("")))});
  fmt::print("{}", table.text());
}

Result<int> run_show(const SessionsOptions& options) {
  const auto record = sessions::read(options.session.root, options.session.id);
  if (!record) return record.error();
  if (options.json) {
    fmt::print("{}", for_terminal(record->document));
    return kExitOk;
  }
  const auto recording = sessions::recording_of(options.session.root, options.session.id);
  print_field("id", record->id);
  print_field("started", record->started_utc);
  print_field("person", record->person);
  print_field("site", record->site);
  print_field("consent", record->consent.version + ", " + record->consent.given_utc);
  print_field("camera", fmt::format("{} {}x{} {}", record->camera.kind, record->camera.width, record->camera.height,
                                    record->camera.name));
  print_field("measured by", "im2fit " + record->versions.im2fit);
  print_field("recording", recording ? *recording : "none");
  print_truth(record->truth);
  print_field("notes", record->notes);
  return kExitOk;
}

double value_in(const Json& result, const std::string& id) {
  const Json* at = &result;
  for (const std::string& key : {std::string("measurements"), id, std::string("value")}) {
    if (!at->is_object()) return std::nan("");
    const auto found = at->find(key);
    if (found == at->end()) return std::nan("");
    at = &*found;
  }
  return at->is_number() ? at->get<double>() : std::nan("");
}

std::string comparison(const Remeasured& done) {
  TextTable table({"measurement", "tape", "then", "now", "now - then", "now - tape"});
  const auto signed_number = [](double value, int decimals) {
    return std::isnan(value) ? "-" : fmt::format("{:+.{}f}", value, decimals);
  };
  for (const MeasurementInfo& info : kMeasurementTable) {
    const std::string id(info.id);
    const int decimals = info.unit == "kg" ? 1 : 0;
    const auto reading = sessions::reading_of(done.record.truth, id);
    const double taken = reading ? reading->mean() : std::nan("");
    const double then = value_in(done.before, id), now = value_in(done.now, id);
    table.add({fmt::format("{} {}", id, info.unit), number(taken, decimals), number(then, decimals),
               number(now, decimals), signed_number(now - then, decimals), signed_number(now - taken, decimals)});
  }
  return table.text();
}

Result<int> run_measure(const SessionsOptions& options) {
  const auto done = remeasure(options.session);
  if (!done) return done.error();
  const bool measured = done->now["measurements"].size() > 0;
  if (options.json)
    fmt::print("{}\n",
               for_terminal(json_text(Json{{"id", done->record.id}, {"then", done->before}, {"now", done->now}}, 2)));
  else if (measured)
    fmt::print("{}", comparison(*done));
  if (measured) return kExitOk;
  print_error("no measurement; needed: " + done->now["guidance"].dump());
  return kExitNoMeasurement;
}

Result<int> run_replay(const SessionsOptions& options) {
  const auto record = sessions::read(options.session.root, options.session.id);
  if (!record) return record.error();
  const auto recording = sessions::recording_of(options.session.root, options.session.id);
  if (!recording) return recording.error();
  LiveOptions live;
  live.session.input.source = *recording;
  live.session.input.body = options.session.body;
  live.session.tracker = options.session.tracker;
  live.session.index = options.session.index;
  if (record->settings.frames > 0) live.session.frames = record->settings.frames;
  live.session.turn = record->settings.turn;
  live.preview_renderer.view = true;
  return run_live(live, nullptr);
}

Result<int> run_delete(const SessionsOptions& options) {
  if (auto gone = sessions::remove(options.session.root, options.session.id); !gone) return gone.error();
  fmt::print("deleted {}\n", options.session.id);
  return kExitOk;
}

void add_models(cli::App& sub, RemeasureOptions& options) {
  add_models_option(sub, options.tracker, options.index, options.body);
  sub.add_option("--body", options.body, "Body file")->type_name("FILE")->capture_default_str();
  sub.add_option("--tracker", options.tracker, "Tracker file")->type_name("FILE")->capture_default_str();
  sub.add_option("--index", options.index, "Index file")->type_name("FILE")->capture_default_str();
}

}  // namespace

void add_sessions(cli::App& app, Command& chosen) {
  cli::App* parent = app.add_subcommand("sessions", "People recorded with tape values: list, show, measure, delete");
  parent->footer("Examples:\n  im2fit sessions list\n  im2fit sessions measure 20260504-123000-k3m8rx2p");
  const auto add = [&](const std::string& name, const std::string& description, const std::string& example,
                       Result<int> (*run)(const SessionsOptions&), bool of_one) {
    auto options = std::make_shared<SessionsOptions>();
    options->session.root = sessions::default_root();
    cli::App* sub = add_command<SessionsOptions>(*parent, chosen, name, description, example, options, run);
    if (of_one)
      sub->add_option("ID", options->session.id, "Id of the session, from im2fit sessions list")->required();
    sub->add_option("--root", options->session.root, "Folder of the sessions")
        ->type_name("DIR")
        ->capture_default_str();
    return std::pair(sub, options);
  };
  auto [list, listed] =
      add("list", "List the sessions, the oldest first", "  im2fit sessions list --json", run_list, false);
  list->add_flag("--json", listed->json, "As JSON");
  auto [show, shown] = add("show", "Show the values of a session", "  im2fit sessions show ID", run_show, true);
  show->add_flag("--json", shown->json, "Print session.json");
  auto [measure, measured] =
      add("measure", "Measure the recording again and compare tape, earlier and new values",
          "  im2fit sessions measure ID\n  im2fit sessions measure ID --index new.i2f", run_measure, true);
  add_models(*measure, measured->session);
  measure->add_option("--out", measured->session.out, "Folder for the new result.json, avatar and overlay")
      ->type_name("DIR");
  measure->add_flag("--json", measured->json, "Print both results as JSON");
  auto [replay, replayed] = add("replay", "Show the recording in this terminal (on stderr)",
                                "  im2fit sessions replay ID", run_replay, true);
  add_models(*replay, replayed->session);
  add("delete", "Delete a session with its recording and results", "  im2fit sessions delete ID", run_delete, true);
  parent->callback([parent] {
    if (!parent->any_subcommand()) cli::App::missing("list, show, measure, replay or delete");
  });
}

}  // namespace im2fit::apps
