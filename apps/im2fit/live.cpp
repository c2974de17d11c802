// SPDX-License-Identifier: Apache-2.0
// live: one person after the other before a camera, until Ctrl-C or --count.
#include <fmt/core.h>

#include <charconv>
#include <chrono>
#include <thread>
#include <utility>

#include "apps/common/events.h"
#include "apps/im2fit/commands.h"
#include "apps/im2fit/onlooker.h"
#include "apps/im2fit/session.h"

namespace im2fit::apps {
namespace {

struct LiveOptions {
  SessionOptions session;
  OnlookerOptions onlooker;
  int count = 0;  // 0: until Ctrl-C or the end
  std::string user = "nearest";
};

constexpr auto kFramePeriod = std::chrono::microseconds(33333);

// 0: the nearest.
std::optional<int> user_of(const std::string& word) {
  if (word == "nearest") return 0;
  int id = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, id);
  if (error != std::errc() || stop != end || id < 1) return std::nullopt;
  return id;
}

// One line on stdout, at once: who reads it may be a program that waits.
Status print_event(const Json& event) {
  fmt::print("{}", line_of(event));
  return flush_output();
}

class LiveRun {
 public:
  LiveRun(const LiveOptions& options, SessionOutcome& outcome, Onlooker& onlooker)
      : options_(options), outcome_(outcome), onlooker_(onlooker), started_(std::chrono::steady_clock::now()) {}

  // After every frame pushed; false ends the run.
  bool go_on() {
    ++frames_;
    if (auto done = look(outcome_.engine->result()); !done) error_ = done.error();
    if (error_ || (options_.count > 0 && persons_ >= options_.count)) return false;
    // A recording is watched at the speed it was made.
    if (options_.onlooker.view && !outcome_.input.source->info().live)
      std::this_thread::sleep_until(started_ + kFramePeriod * frames_);
    return true;
  }

  // After the run: whoever stood there last may be measured from fewer frames.
  Result<int> conclude_run() {
    if (error_) return *error_;
    if (onlooker_.error()) return *onlooker_.error();
    if (auto done = look(outcome_.engine->result()); !done) return done.error();
    if (error_) return *error_;
    if (persons_ == 0) return report_nobody();
    if (!options_.session.json) return kExitOk;
    if (auto printed = print_event({{"event", "end"}, {"frame", frames_}, {"persons", persons_}}); !printed)
      return printed.error();
    return kExitOk;
  }
  const std::string& tables() const { return tables_; }

 private:
  Status look(const EngineResult& result) {
    if (onlooker_.error()) return *onlooker_.error();
    if (result.session != session_) {
      session_ = result.session;
      const bool left = std::exchange(reported_, false);
      if (auto said = left ? say_left() : Ok{}; !said) return said;
    }
    if (auto said = say_state(result); !said) return said;
    if (is_stuck(result)) outcome_.engine->next_person();
    if (!result.measured || reported_) return Ok{};
    reported_ = true;
    ++persons_;
    outcome_.engine->finish();
    if (auto done = report_person(); !done) return done;
    outcome_.engine->next_person();
    return Ok{};
  }

  Status say_state(const EngineResult& result) {
    const ShownState state = shown_state(result);
    if (said_ && state == state_) return Ok{};
    said_ = true;
    state_ = state;
    if (options_.session.json) return print_event(state_event(frames_, result));
    if (!options_.onlooker.view)
      fmt::print(stderr, "{}  needed: {}\n", state_words(result, options_.session.frames),
                 guidance_words(result.guidance));
    return Ok{};
  }

  Status say_left() {
    if (options_.session.json) return print_event(left_event(frames_, persons_));
    if (!options_.onlooker.view) fmt::print(stderr, "person {} has left\n", persons_);
    return Ok{};
  }

  // --out itself for the only person asked for, else a folder for each.
  std::string folder() const {
    if (options_.session.out.empty() || options_.count == 1) return options_.session.out;
    return fmt::format("{}/person-{:03}", options_.session.out, persons_);
  }

  Status report_person() {
    if (auto concluded = conclude(outcome_); !concluded) return concluded;
    const std::string out = folder();
    if (!out.empty()) {
      if (auto made = make_directory(out); !made) return made;
      if (auto written = write_outputs(outcome_, out); !written) return written;
    }
    onlooker_.say(fmt::format("person {}: {}", persons_, summary(outcome_.report)));
    if (options_.session.json) {
      Json event = measured_event(frames_, persons_, outcome_.report);
      if (!out.empty()) event["out"] = out;
      return print_event(event);
    }
    std::string table = fmt::format("person {}\n{}", persons_, result_table(outcome_));
    if (!out.empty()) table += fmt::format("written to {}\n", out);
    // The view has the terminal: tables follow it.
    if (options_.onlooker.view) {
      tables_ += table;
      return Ok{};
    }
    fmt::print("{}", table);
    return flush_output();
  }

  Result<int> report_nobody() {
    if (auto concluded = conclude(outcome_); !concluded) return concluded.error();
    const EngineResult& result = outcome_.report.result;
    // Damaged frames among good ones are left out; nothing but damage is no stream.
    if (result.frames_seen == 0 && outcome_.tap->first_damage()) return *outcome_.tap->first_damage();
    if (!options_.session.json) return report_session(outcome_, options_.session);
    if (!options_.session.out.empty())
      if (auto written = write_outputs(outcome_, options_.session.out); !written) return written.error();
    Json event = {{"event", "end"}, {"frame", frames_}, {"persons", 0}};
    event["result"] = Json::parse(result_json(outcome_.report));
    if (auto printed = print_event(event); !printed) return printed.error();
    return kExitNoMeasurement;
  }

  const LiveOptions& options_;
  SessionOutcome& outcome_;
  Onlooker& onlooker_;
  std::chrono::steady_clock::time_point started_;
  std::uint64_t frames_ = 0;
  int persons_ = 0;
  std::uint32_t session_ = 0;
  bool reported_ = false;
  bool said_ = false;
  ShownState state_;
  std::string tables_;
  std::optional<Error> error_;
};

Result<int> run_live_shown(const LiveOptions& options, std::string& tables) {
  std::unique_ptr<Onlooker> onlooker;
  if (!options.onlooker.overlay.empty())
    if (const auto made = make_directory(options.onlooker.overlay); !made) return made.error();
  FrameWatch watch;
  const bool watched = options.onlooker.view || !options.onlooker.overlay.empty();
  if (watched) watch = [&](const FrameSeen& frame) { onlooker->see(frame); };
  SessionOptions session = options.session;
  if (session.json)
    session.input.camera_changed = [](const hal::ReconnectStats& stats, const hal::SourceInfo& source) {
      (void)print_event(camera_event(stats, source));  // a closed pipe is noticed with the next event
    };
  else if (options.onlooker.view)
    session.input.camera_changed = [&](const hal::ReconnectStats& stats, const hal::SourceInfo& source) {
      onlooker->say(camera_words(stats, source));
    };
  auto outcome = open_session(session, std::move(watch), nullptr);
  if (!outcome) return outcome.error();
  onlooker =
      std::make_unique<Onlooker>(options.onlooker, outcome->input.source->info().intrinsics, options.session.frames);
  LiveRun live(options, *outcome, *onlooker);
  const auto done = run(*outcome->engine, *outcome->tap, [&] { return live.go_on(); });
  auto code = live.conclude_run();
  tables = live.tables();
  if (!done) return done.error();
  if (code && !options.onlooker.overlay.empty() && !options.session.json)
    tables += fmt::format("{} pictures in {}\n", onlooker->pictures(), options.onlooker.overlay);
  return code;
}

Result<int> run_live(const LiveOptions& asked) {
  LiveOptions options = asked;
  options.session.user = user_of(options.user).value_or(0);
  std::string tables;
  auto code = run_live_shown(options, tables);
  fmt::print("{}", tables);
  return code;
}

}  // namespace

void add_live(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<LiveOptions>();
  options->session.live = true;
  options->session.input.reconnect_s = -1;
  auto* sub = add_command<LiveOptions>(
      app, chosen, "live", "Guide and measure one person after the other before a camera, until Ctrl-C",
      "  im2fit live openni2 --rotate 90 --view\n  im2fit live openni2 --count 1 --out me\n  im2fit live FOLDER "
      "--overlay pictures --overlay-every 5\n  im2fit live openni2 --json | ./kiosk",
      options, run_live);
  add_session_options(*sub, options->session);
  sub->get_option("--out")->description(
      "Folder for result.json, avatar.glb, .obj, .bvh and overlay.png: with --count 1 "
      "in it, else in person-001 and so on");
  sub->get_option("--json")->description(
      "Print events on stdout, one JSON object a line: state, measured, left, camera, end");
  sub->remove_option(sub->get_option("--timing"));
  sub->add_option("--count", options->count, "End after so many people; 0: at Ctrl-C or the source's end")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  sub->add_option("--user", options->user, "Whom to measure: nearest, or one id only")
      ->type_name("nearest|ID")
      ->check([](const std::string& word) {
        return user_of(word) ? std::string() : "use nearest, or the number live shows with a person";
      })
      ->capture_default_str();
  sub->add_option("--overlay", options->onlooker.overlay, "Folder for a picture of every frame: skeleton over depth")
      ->type_name("DIR");
  sub->add_option("--overlay-every", options->onlooker.overlay_every, "Only every so many frames")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  sub->add_flag("--view", options->onlooker.view, "Show the same in this terminal (on stderr), ten times a second");
}

}  // namespace im2fit::apps
