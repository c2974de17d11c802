// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "apps/common/events.h"
#include "apps/common/facts_form.h"
#include "apps/common/input.h"
#include "apps/common/manual.h"
#include "apps/common/measuring.h"
#include "apps/common/paths.h"
#include "apps/im2fitd/config.h"
#include "apps/im2fitd/log.h"
#include "apps/im2fitd/notify.h"
#include "apps/im2fitd/publisher.h"
#include "core/file.h"
#include "formats/json_file.h"
#include "hal/folder/camera_yaml.h"
#include "hal/frame_path.h"
#include "hal/open/open.h"
#include "hal/source.h"
#include "report/full_result.h"

namespace im2fit::daemon {
namespace {

// What signals ask for; set by their handlers.
struct Wishes {
  static inline std::atomic<bool> stop{false};    // SIGTERM, SIGINT
  static inline std::atomic<bool> reload{false};  // SIGHUP
};

class Daemon {
 public:
  // `config_path` is read again at SIGHUP. Loads all data and makes the socket. Errors: those of the parts below.
  static Result<std::unique_ptr<Daemon>> create(const Config& config, const std::string& config_path,
                                                Notifier& notifier);
  // What create() would refuse, and a source no camera can ever be opened from, without making anything.
  static Status check(const Config& config);
  // Until SIGTERM or the end of a recording (nothing), or a new sound configuration (that). Waits for a camera that
  // is not there yet and for one that went away.
  Result<std::optional<Config>> run();

 private:
  Daemon(const Config& config, std::string config_path, Notifier& notifier, MeasuringData data)
      : config_(config), config_path_(std::move(config_path)), notifier_(notifier), data_(std::move(data)) {}
  bool end_requested();
  Result<std::unique_ptr<hal::Source>> open_source();
  Result<std::unique_ptr<hal::Source>> wait_for_camera(const hal::ReconnectingSource::Opener& opener);
  void camera_changed(const hal::ReconnectStats& stats);
  Status measure_people(hal::Source& source);
  Status handle_result(const hal::Source& source);
  Status report_person(const hal::Source& source);
  Status say_person(const EngineResult& result, const hal::Source& source);
  Status serve_clients(const hal::Source* source);
  bool take_facts(const ClientLine& line, const hal::Source* source);
  void keep(const std::string& result);
  void feed_watchdog(bool waiting);
  std::string greeting() const;
  void say(const apps::Json& event);
  void status(const std::string& text) const { notifier_.send("STATUS=" + text); }

  Config config_;
  std::string config_path_;
  Notifier& notifier_;
  MeasuringData data_;
  std::string state_directory_;
  std::unique_ptr<Publisher> publisher_;
  std::unique_ptr<Engine> engine_;
  std::atomic<std::uint64_t> processed_{0};  // frames out of the engine
  std::uint64_t processed_when_fed_ = 0;
  hal::SourceInfo camera_;
  apps::Json camera_event_;
  apps::Json state_event_;
  std::optional<Config> reloaded_;
  std::optional<apps::ShownState> shown_;
  std::optional<KnownFacts> facts_;  // of the person who is measured next
  std::uint64_t frames_ = 0;
  std::uint32_t session_ = 0;
  int persons_ = 0;
  bool reported_ = false;
  bool keeping_fails_ = false;
};

constexpr int kWaitMs = 100;  // how late a client or a signal may be seen
constexpr int kFarewellMs = 500;
constexpr int kRetryFirstMs = 100;
constexpr int kRetryMaxMs = 1000;

hal::OpenOptions opening_of(const Config& config) {
  hal::OpenOptions opening;
  if (config.rotate_deg >= 0) opening.rotate_deg = config.rotate_deg;
  opening.camera_yaml_path = config.camera_yaml;
  return opening;
}

PublisherOptions publishing_of(const Config& config) {
  return {config.socket_path, config.socket_mode, config.socket_group, config.clients_max,
          config.client_buffer_bytes};
}

// A camera that is not there, in use or not yet allowed may be soon; wrong words never are.
bool may_pass(const Error& error) {
  return error.code == ErrorCode::no_device || error.code == ErrorCode::io || error.code == ErrorCode::timeout;
}

Result<std::unique_ptr<Daemon>> Daemon::create(const Config& config, const std::string& config_path,
                                               Notifier& notifier) {
  auto data = apps::load_measuring_data(config.measuring, config.body);
  if (!data) return data.error();
  for (const std::string& warning : data->warnings) log(Level::warning, warning);
  std::unique_ptr<Daemon> made(new Daemon(config, config_path, notifier, std::move(*data)));
  // systemd may name several, with colons between.
  const std::string given = environment("STATE_DIRECTORY");
  made->state_directory_ = config.state_directory.empty() ? given.substr(0, given.find(':')) : config.state_directory;
  if (!made->state_directory_.empty())
    if (auto there = make_directory(made->state_directory_); !there) return there.error();
  auto publisher = Publisher::open(publishing_of(config));
  if (!publisher) return publisher.error();
  made->publisher_ = std::move(*publisher);
  return made;
}

Status Daemon::check(const Config& config) {
  if (auto data = apps::load_measuring_data(config.measuring, config.body); !data) return data.error();
  if (auto sound = Publisher::check(publishing_of(config)); !sound) return sound;
  if (std::error_code code; !config.state_directory.empty() &&
                            std::filesystem::exists(config.state_directory, code) &&
                            !std::filesystem::is_directory(config.state_directory, code))
    return Error{ErrorCode::io, "state_directory " + config.state_directory + " exists and is not a directory"};
  if (!config.camera_yaml.empty())
    if (auto camera = hal::load_camera_yaml(config.camera_yaml); !camera) return camera.error();
  if (hal::camera_opener(config.source, opening_of(config))) return Ok{};
  auto source = hal::open_source(config.source, opening_of(config));
  return source ? Status(Ok{}) : source.error();
}

bool Daemon::end_requested() {
  if (Wishes::stop) return true;
  if (!Wishes::reload.exchange(false)) return false;
  auto config = load_config(config_path_);
  if (!config) {
    log(Level::error, config.error().message + "; continuing with the earlier configuration");
    return false;
  }
  log(Level::notice, config_path_ + " was read again");
  reloaded_ = std::move(*config);
  return true;
}

Result<std::optional<Config>> Daemon::run() {
  say({{"event", "camera"}, {"state", "WAITING"}});
  notifier_.send("READY=1\nSTATUS=opening " + config_.source);
  log(Level::info, "listening at " + config_.socket_path + ", source " + config_.source);
  auto source = open_source();
  if (!source) return source.error();
  Status done = *source == nullptr ? Ok{} : measure_people(**source);
  engine_.reset();
  say({{"event", "end"}, {"frame", frames_}, {"persons", persons_}});
  publisher_->flush(kFarewellMs);
  if (!done) return done.error();
  return std::move(reloaded_);
}

// Null: the end was requested meanwhile.
Result<std::unique_ptr<hal::Source>> Daemon::open_source() {
  std::unique_ptr<hal::Source> source;
  if (const auto opener = hal::camera_opener(config_.source, opening_of(config_))) {
    auto camera = wait_for_camera(opener);
    if (!camera) return camera.error();
    source = std::move(*camera);
  } else {
    apps::InputOptions input;
    input.source = config_.source;
    input.rotate_deg = config_.rotate_deg;
    input.camera_yaml = config_.camera_yaml;
    input.body = config_.body;
    auto opened = apps::open_input(input);
    if (!opened) return opened.error();
    source = std::move(opened->source);
  }
  if (source == nullptr) return source;
  camera_ = source->info();
  camera_changed({});
  return source;
}

Result<std::unique_ptr<hal::Source>> Daemon::wait_for_camera(const hal::ReconnectingSource::Opener& opener) {
  hal::ReconnectOptions reconnect;
  reconnect.changed = [this](const hal::ReconnectStats& stats) { camera_changed(stats); };
  std::string reason;
  for (int pause_ms = kRetryFirstMs;; pause_ms = std::min(2 * pause_ms, kRetryMaxMs)) {
    auto source = hal::ReconnectingSource::open(opener, reconnect);
    if (source) return std::unique_ptr<hal::Source>(std::move(*source));
    if (!may_pass(source.error())) return source.error();
    if (reason != source.error().message) {
      reason = source.error().message;
      log(Level::warning, "waiting for the camera: " + reason);
      status("waiting for the camera: " + reason);
      say({{"event", "camera"}, {"state", "WAITING"}, {"reason", reason}});
    }
    for (int slept_ms = 0; slept_ms < pause_ms; slept_ms += kWaitMs) {
      if (end_requested()) return std::unique_ptr<hal::Source>();
      feed_watchdog(true);
      (void)serve_clients(nullptr);  // nobody is measured yet, so nothing can fail
      std::this_thread::sleep_for(std::chrono::milliseconds(kWaitMs));
    }
  }
}

void Daemon::camera_changed(const hal::ReconnectStats& stats) {
  const bool first = stats.presence == hal::Presence::present && stats.lost == 0;
  const std::string words = first ? "measuring before " + camera_.name : apps::camera_words(stats, camera_);
  log(stats.presence == hal::Presence::present ? Level::notice : Level::warning, words);
  status(words);
  say(apps::camera_event(stats, camera_));
}

Status Daemon::measure_people(hal::Source& source) {
  auto engine = apps::make_engine(config_.measuring, data_, camera_,
                                  [this](const FrameSeen&) { processed_.fetch_add(1, std::memory_order_relaxed); });
  if (!engine) return engine.error();
  engine_ = std::move(*engine);
  if (auto started = source.start(); !started) return started;
  Status status = Ok{};
  bool ended = false;
  while (status && !ended && !end_requested()) {
    if (status = serve_clients(&source); !status) break;
    const auto pumped = pump(source, *engine_, kWaitMs);
    feed_watchdog(source.lost());
    if (!pumped) {
      status = pumped.error();
    } else if (*pumped == Pumped::frame) {
      ++frames_;
      status = handle_result(source);
    } else if (*pumped == Pumped::end) {
      ended = true;
    }
  }
  source.stop();
  if (!status || !ended) return status;
  engine_->finish();
  return handle_result(source);
}

Status Daemon::handle_result(const hal::Source& source) {
  const EngineResult result = engine_->result();
  if (result.session != session_) {
    session_ = result.session;
    if (std::exchange(reported_, false)) say(apps::left_event(frames_, persons_));
    // The same person, begun anew.
    if (facts_)
      if (auto set = engine_->set_known(*facts_, session_); !set) return set;
  }
  if (const auto shown = apps::shown_state(result); shown != shown_) {
    shown_ = shown;
    say(apps::state_event(frames_, result));
  }
  if (apps::is_stuck(result)) engine_->next_person();
  if (!result.measured || reported_) return engine_->fault();
  return report_person(source);
}

Status Daemon::report_person(const hal::Source& source) {
  reported_ = true;
  ++persons_;
  facts_.reset();
  engine_->finish();
  const EngineResult result = engine_->result();
  if (auto sound = engine_->fault(); !sound) return sound;
  if (auto said = say_person(result, source); !said) return said;
  log(Level::info, fmt::format("person {} is measured, from {} frames", persons_, result.frames_used));
  engine_->next_person();
  return Ok{};
}

Status Daemon::say_person(const EngineResult& result, const hal::Source& source) {
  auto person = apps::measured_person(result, data_, source.info());
  if (!person) return person.error();
  person->frames_damaged = source.stats().damaged;
  if (const std::string note = apps::body_note(*person); !note.empty()) log(Level::warning, note);
  const std::string text = full_result_json(*person, data_);
  say(apps::measured_event(frames_, persons_, text));
  keep(text);
  return Ok{};
}

// `source`: null while no camera is there. A person who is measured already is reported once, with the latest facts.
Status Daemon::serve_clients(const hal::Source* source) {
  publisher_->serve(greeting());
  bool corrected = false;
  for (const ClientLine& line : publisher_->take_lines())
    if (take_facts(line, source)) corrected = true;
  if (!corrected) return Ok{};
  const EngineResult result = engine_->result();
  return result.measured && result.session == session_ ? say_person(result, *source) : Status(Ok{});
}

// {"known": {...}}: what the person of the present session reports. The log has no value of it. True: of a person who
// is measured already.
bool Daemon::take_facts(const ClientLine& line, const hal::Source* source) {
  const auto refuse = [&](const std::string& reason) {
    publisher_->answer(line.client, apps::line_of({{"event", "refused"}, {"reason", reason}}));
    return false;
  };
  if (line.too_long) return refuse(fmt::format("a line has more than {} bytes", kClientLineMax));
  const auto read = parse_json<apps::Json>(line.text, "the line");
  const apps::Json sent = read ? *read : apps::Json();
  if (!sent.is_object() || sent.size() != 1 || !sent.contains("known") || !sent["known"].is_object())
    return refuse("expected {\"known\": {...}} on one line (docs/daemon.md)");
  const auto facts = apps::facts_of_form(sent["known"].dump());
  if (!facts) return refuse("known: " + facts.error().message);
  if (source == nullptr || engine_ == nullptr) return refuse("no camera is present, so nobody is measured");
  // The engine may have gone on to the next person since the last frame that was handled.
  const std::uint32_t session = engine_->result().session;
  if (auto set = engine_->set_known(*facts, session); !set) return refuse("known: " + set.error().message);
  const bool measured = reported_ && session == session_;
  if (!measured) facts_ = *facts;
  say({{"event", "known"}, {"frame", frames_}, {"person", measured ? persons_ : persons_ + 1}});
  return measured;
}

// Measuring goes on when the disk is full.
void Daemon::keep(const std::string& result) {
  if (state_directory_.empty()) return;
  const auto written = write_file_atomically(state_directory_ + "/last-result.json", result, Readable::by_owner);
  if (!written && !keeping_fails_) log(Level::error, written.error().message + "; results are only published");
  keeping_fails_ = !written;
}

// Fed by frames that came out of the engine: one that hangs, or a camera that is there and silent, is not fed. To
// wait for a camera is work too.
void Daemon::feed_watchdog(bool waiting) {
  const std::uint64_t processed = processed_.load(std::memory_order_relaxed);
  if (!waiting && processed == processed_when_fed_) return;
  processed_when_fed_ = processed;
  notifier_.feed_watchdog(hal::monotonic_ns());
}

std::string Daemon::greeting() const {
  std::string lines = apps::line_of(
      {{"event", "hello"}, {"protocol", "im2fitd/1"}, {"version", IM2FIT_VERSION}, {"persons", persons_}});
  for (const apps::Json* event : {&camera_event_, &state_event_})
    if (!event->is_null()) lines += apps::line_of(*event);
  return lines;
}

void Daemon::say(const apps::Json& event) {
  if (event["event"] == "camera") camera_event_ = event;
  if (event["event"] == "state") state_event_ = event;
  publisher_->publish(apps::line_of(event));
}

struct Words {
  std::string config = "/etc/im2fit/im2fitd.yaml";
  bool check = false;
};

void catch_signals() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGHUP, [](int) { Wishes::reload = true; });
  for (const int number : {SIGTERM, SIGINT}) std::signal(number, [](int) { Wishes::stop = true; });
}

Status serve(const Words& words) {
  auto config = load_config(words.config);
  if (!config) return config.error();
  if (words.check) return Daemon::check(*config);
  catch_signals();
  Notifier notifier;
  for (;;) {
    auto daemon = Daemon::create(*config, words.config, notifier);
    if (!daemon) return daemon.error();
    auto next = (*daemon)->run();
    if (!next) return next.error();
    if (!*next) break;
    config = std::move(**next);
  }
  notifier.send("STOPPING=1\nSTATUS=stopped");
  log(Level::info, "stopped");
  return Ok{};
}

}  // namespace
}  // namespace im2fit::daemon

int main(int argc, char** argv) {
  using namespace im2fit::daemon;
  CLI::App app{
      "Measures one person after the other in front of a camera and publishes the results at a local socket.",
      "im2fitd"};
  app.footer(
      "Made for systemd: see im2fitd.service and docs/daemon.md. Exit codes: 0 stopped, 1 failed, 2 wrong use.");
  Words words;
  app.set_version_flag("--version", std::string("im2fitd ") + IM2FIT_VERSION, "Print the version and exit");
  app.add_option("--config", words.config, "Configuration")->type_name("YAML")->capture_default_str();
  app.add_flag("--check", words.check, "Only check the configuration and its files, as at a start");
  if (const auto manual = im2fit::apps::manual_asked(app, argc, argv))
    return std::fputs(manual->c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? 0 : 1;
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    log(Level::error, std::string(error.what()) + " (see im2fitd --help)");
    return 2;
  }
  try {
    const auto done = serve(words);
    if (done) return 0;
    log(Level::error, done.error().message);
  } catch (const std::exception& error) {  // libraries for JSON and text throw
    log(Level::error, error.what());
  }
  return 1;
}
