// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/live_run.h"

#include <fmt/core.h>

#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "formats/json_file.h"
#include "report/full_result.h"

namespace im2fit::apps {
namespace {

// 0: the nearest.
constexpr auto kFramePeriod = std::chrono::microseconds(33333);

// One line on stdout, flushed at once: the reader may be a program that waits.
Status print_event(const Json& event) {
  fmt::print("{}", line_of(event));
  return flush_output();
}

class LiveRun {
 public:
  LiveRun(const LiveOptions& options, SessionOutcome& outcome, PreviewRenderer& preview_renderer,
          LiveListener* listener)
      : options_(options),
        outcome_(outcome),
        preview_(preview_renderer),
        listener_(listener),
        permit_(listener != nullptr ? listener->permit() : 0),
        started_(std::chrono::steady_clock::now()) {
    if (permit_ != 0) listener_->begin_person(permit_);
  }

  // After every frame pushed; false ends the run.
  bool go_on() {
    ++frames_;
    if (!permitted()) return true;
    attend();
    if (auto done = handle_result(outcome_.engine->result()); !done) error_ = done.error();
    if (error_ || (options_.count > 0 && persons_ >= options_.count)) return false;
    // A recording is watched at the speed it was made.
    if ((options_.preview_renderer.view || listener_ != nullptr) && !outcome_.input.source->info().live)
      std::this_thread::sleep_until(started_ + kFramePeriod * frames_);
    return true;
  }

  // What the person reports, before and after the answer; between frames, and while none are taken.
  void attend() {
    if (listener_ == nullptr) return;
    use_region();
    if (permit_ == 0) return;
    const ReportedFacts now = listener_->reported(permit_);
    if (now.count == reported_facts_.count) return;
    reported_facts_ = now;
    if (now.count == 0) unconditioned_.reset();  // their visit is over
    // Where the person has left the engine's session is the next one's already.
    if (!unconditioned_ || outcome_.engine->result().session == unconditioned_->session) use_facts(now.facts);
    if (!unconditioned_) return;
    // While the answer is made again no frames are taken, as in handle_result.
    const bool still_here = outcome_.engine->result().session == unconditioned_->session;
    if (still_here) outcome_.engine->finish();
    if (auto done = correct_person(); !done) print_error("the answer cannot be corrected: " + done.error().message);
    if (still_here) outcome_.engine->next_person();
  }

  // After the run: the person in front of the camera at the end may be measured from fewer frames.
  Result<int> conclude_run() {
    if (error_) return *error_;
    if (preview_.error()) return *preview_.error();
    if (!permitted())
      outcome_.engine->reset();
    else if (auto done = handle_result(outcome_.engine->result()); !done)
      return done.error();
    if (error_) return *error_;
    if (persons_ == 0) return report_no_person();
    if (auto sent = publish({{"event", "end"}, {"frame", frames_}, {"persons", persons_}}); !sent)
      return sent.error();
    return kExitOk;
  }
  const std::string& tables() const { return tables_; }

 private:
  // False when the engine knows another person than the permitted one: its knowledge is dropped.
  bool permitted() {
    if (listener_ == nullptr) return true;
    const std::uint64_t permit = listener_->permit();
    if (permit == permit_) return true;
    // 0 while the person before is shown: the engine gets no frames, and its knowledge goes with the next number.
    if (permit == 0) return false;
    permit_ = permit;
    begin_anew();
    started_ = std::chrono::steady_clock::now() - kFramePeriod * frames_;  // a recording stood still
    return false;
  }

  void begin_anew() {
    outcome_.engine->reset();
    session_ = outcome_.engine->result().session;
    reported_ = state_known_ = false;
    unconditioned_.reset();
    reported_facts_ = {};
    if (listener_ != nullptr) listener_->begin_person(permit_);
    attend();
  }

  // As the operator's page has it, before the next frame.
  void use_region() {
    const OperatorRegion now = listener_->region();
    if (now.count == region_count_) return;
    region_count_ = now.count;
    if (auto taken = outcome_.engine->set_region(now.region); !taken) error_ = taken.error();
  }

  void use_facts(const KnownFacts& facts) {
    if (auto taken = outcome_.engine->set_known(facts, session_); !taken) error_ = taken.error();
  }

  void give_up() {
    if (options_.recorded)
      begin_anew();
    else
      outcome_.engine->next_person();
  }

  Status publish(const Json& event) {
    if (listener_ != nullptr) listener_->publish(event);
    return options_.session.json ? print_event(event) : Ok{};
  }

  Status handle_result(const EngineResult& result) {
    if (preview_.error()) return *preview_.error();
    if (result.session != session_) {
      session_ = result.session;
      const bool left = std::exchange(reported_, false);
      if (!left && reported_facts_.count > 0) use_facts(reported_facts_.facts);  // the same person anew
      if (auto reported = left ? report_left() : Ok{}; !reported) return reported;
    }
    if (auto reported = report_state(result); !reported) return reported;
    if (is_stuck(result)) give_up();
    if (!result.measured || reported_) return Ok{};
    reported_ = true;
    ++persons_;
    outcome_.engine->finish();
    if (reported_facts_.count > 0) {  // facts corrected later begin from the answer without
      use_facts({});
      unconditioned_ = outcome_.engine->result();
      use_facts(reported_facts_.facts);
    }
    if (auto done = report_person(); !done) return done;
    outcome_.engine->next_person();
    return Ok{};
  }

  Status report_state(const EngineResult& result) {
    const ShownState state = shown_state(result);
    if (state_known_ && state == state_) return Ok{};
    state_known_ = true;
    state_ = state;
    if (auto sent = publish(state_event(frames_, result)); !sent) return sent;
    if (!options_.session.json && !options_.preview_renderer.view)
      fmt::print(stderr, "{}  needed: {}\n", state_words(result, options_.session.frames),
                 guidance_words(result.guidance, result.arms_close));
    return Ok{};
  }

  Status report_left() {
    if (auto sent = publish(left_event(frames_, persons_)); !sent) return sent;
    if (!options_.session.json && !options_.preview_renderer.view)
      fmt::print(stderr, "person {} has left\n", persons_);
    return Ok{};
  }

  // --out itself for the only person wanted, else a folder for each.
  std::string folder() const {
    if (options_.session.out.empty() || options_.count == 1) return options_.session.out;
    return fmt::format("{}/person-{:03}", options_.session.out, persons_);
  }

  // With corrected facts: the same again, for the person whose answer stands.
  Status correct_person() {
    if (auto concluded = conclude_again(outcome_, *unconditioned_, reported_facts_.facts); !concluded)
      return concluded;
    return show_person(true);
  }

  Status show_person(bool corrected) {
    const std::string out = folder();
    if (listener_ != nullptr)
      if (auto dressed = dress(outcome_); !dressed) return dressed;
    if (!out.empty()) {
      if (auto made = make_directory(out); !made) return made;
      const WantedFiles wanted = wanted_files(options_.session);
      if (auto written = corrected ? rewrite_outputs(outcome_, out, wanted) : write_outputs(outcome_, out, wanted);
          !written)
        return written;
    }
    preview_.say(fmt::format("person {}: {}", persons_, summary(outcome_.person)));
    Json event = measured_event(frames_, persons_, full_result_json(outcome_.person, outcome_.data));
    if (!out.empty()) event["out"] = out;
    if (corrected) event["corrected"] = true;
    if (listener_ != nullptr)
      if (auto seen = listener_->measured(outcome_); !seen) return seen;
    return publish(event);
  }

  Status report_person() {
    if (auto concluded = conclude(outcome_); !concluded) return concluded;
    if (auto shown = show_person(false); !shown) return shown;
    const std::string out = folder();
    if (options_.session.json || !options_.print_results) return Ok{};
    std::string table = fmt::format("person {}\n{}", persons_, result_table(outcome_, options_.session.paper));
    if (!out.empty()) table += fmt::format("written to {}\n", out);
    // The view has the terminal: tables follow it.
    if (options_.preview_renderer.view) {
      tables_ += table;
      return Ok{};
    }
    fmt::print("{}", table);
    return flush_output();
  }

  Result<int> report_no_person() {
    if (auto concluded = conclude(outcome_); !concluded) return concluded.error();
    const EngineResult& result = outcome_.person.result;
    // Damaged frames among good ones are left out. If all frames are damaged there is no stream.
    if (result.frames_seen == 0 && outcome_.tap->first_damage()) return *outcome_.tap->first_damage();
    if (options_.session.json && !options_.session.out.empty())
      if (auto written = write_outputs(outcome_, options_.session.out, wanted_files(options_.session)); !written)
        return written.error();
    Json event = {{"event", "end"}, {"frame", frames_}, {"persons", 0}};
    event["result"] = *parse_json<Json>(full_result_json(outcome_.person, outcome_.data), "result.json");
    if (auto sent = publish(event); !sent) return sent.error();
    // Whoever stops a page, or its service, stops it between people: nothing has failed.
    if (listener_ != nullptr && interrupted()) return kExitOk;
    return options_.session.json ? kExitNoMeasurement : report_session(outcome_, options_.session);
  }

  const LiveOptions& options_;
  SessionOutcome& outcome_;
  PreviewRenderer& preview_;
  LiveListener* listener_;
  std::uint64_t permit_;
  std::chrono::steady_clock::time_point started_;
  std::uint64_t frames_ = 0;
  int persons_ = 0;
  std::uint32_t session_ = 0;
  bool reported_ = false;
  ReportedFacts reported_facts_;               // of the person with permit_
  std::uint32_t region_count_ = 0;             // of the region that the engine has
  std::optional<EngineResult> unconditioned_;  // the reported answer without the facts; none: no answer yet
  bool state_known_ = false;
  ShownState state_;
  std::string tables_;
  std::optional<Error> error_;
};

Result<int> run_live_shown(const LiveOptions& options, LiveListener* listener, std::string& tables) {
  std::unique_ptr<PreviewRenderer> preview_renderer;
  if (!options.preview_renderer.overlay.empty())
    if (const auto made = make_directory(options.preview_renderer.overlay); !made) return made.error();
  FrameWatch watch;
  const bool watched = options.preview_renderer.view || !options.preview_renderer.overlay.empty();
  if (watched || listener != nullptr)
    watch = [&](const FrameSeen& frame) {
      preview_renderer->see(frame);
      if (listener != nullptr) listener->see(frame);
    };
  SessionOptions session = options.session;
  session.input.camera_changed = [&](const hal::ReconnectStats& stats, const hal::SourceInfo& source) {
    const Json event = camera_event(stats, source);
    if (listener != nullptr) listener->publish(event);
    if (session.json)
      (void)print_event(event);  // a closed pipe is noticed with the next event
    else if (options.preview_renderer.view)
      preview_renderer->say(camera_words(stats, source));
    else if (stats.presence != hal::Presence::given_up)  // that is an error of its own
      print_error(camera_words(stats, source));
  };
  auto outcome = open_session(session, std::move(watch), nullptr);
  if (!outcome) return outcome.error();
  preview_renderer = std::make_unique<PreviewRenderer>(
      options.preview_renderer, outcome->input.source->info().intrinsics, options.session.frames);
  if (listener != nullptr) listener->begin(*outcome);
  LiveRun live(options, *outcome, *preview_renderer, listener);
  if (listener != nullptr)
    outcome->tap->hold_while([&live, listener] {
      live.attend();
      return listener->permit() == 0;
    });
  const auto done = run(*outcome->engine, *outcome->tap, [&] { return live.go_on(); });
  auto code = live.conclude_run();
  tables = live.tables();
  if (!done) return done.error();
  if (code && !options.preview_renderer.overlay.empty() && !options.session.json)
    tables += fmt::format("{} pictures in {}\n", preview_renderer->pictures(), options.preview_renderer.overlay);
  return report_motion(*outcome, options.session, std::move(code));
}

}  // namespace

Result<int> run_live(const LiveOptions& given, LiveListener* listener) {
  LiveOptions options = given;
  options.session.one_after_another = true;
  // A motion, pictures of every frame and a recording leave none out.
  options.session.rest =
      options.session.motion.empty() && options.preview_renderer.overlay.empty() && !options.recorded;
  std::string tables;
  auto code = run_live_shown(options, listener, tables);
  fmt::print("{}", tables);
  return code;
}

void add_live_options(cli::App& sub, LiveOptions& options) {
  options.session.live = true;
  options.session.input.reconnect_s = -1;
  add_session_options(sub, options.session);
  sub.get_option("--out")->description(
      "Folder for result.json, avatar.glb, .obj, .bvh and overlay.png; except with --count 1, each person has a "
      "subfolder: person-001 and so on");
  sub.get_option("--json")->description(
      "Print events on stdout, one JSON object per line: state, measured, left, camera, end");
  sub.remove_option(sub.get_option("--timing"));
  sub.add_option("--count", options.count, "End after N people; 0: at Ctrl-C or at the end of the source")
      ->range(0, 1'000'000)
      ->capture_default_str();
}

}  // namespace im2fit::apps
