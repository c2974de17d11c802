// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/daemon.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "apps/common/input.h"
#include "apps/common/paths.h"
#include "apps/im2fitd/log.h"
#include "core/file.h"
#include "hal/folder/camera_yaml.h"
#include "hal/frame_path.h"
#include "report/full_result.h"

namespace im2fit::daemon {
namespace {

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

// Frames that no one has consented to: they are taken from the camera, which would stop otherwise, and not looked at.
class Unseen : public FrameSink {
 public:
  Unseen(std::vector<std::uint16_t>& pixels, const Intrinsics& size) : pixels_(pixels), size_(size) {
    pixels_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  }
  Result<DepthImage> acquire() override { return DepthImage{pixels_.data(), size_.width, size_.height}; }
  Status commit(const hal::FrameInfo&) override {
    std::fill(pixels_.begin(), pixels_.end(), std::uint16_t{0});
    return Ok{};
  }

 private:
  std::vector<std::uint16_t>& pixels_;
  Intrinsics size_;
};

}  // namespace

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
  made->consented_ = !config.consent_ask;
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
  if (SignalWishes::stop) return true;
  if (!SignalWishes::reload.exchange(false)) return false;
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
  if (config_.consent_ask) say({{"event", "visit"}, {"state", "ASKING"}});
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
  // Whoever waits for a mask of the next frame may wait for long.
  if (stats.presence != hal::Presence::present)
    for (const auto& [client, id] : std::exchange(masks_.clients, {})) refuse(client, kNoCamera, id);
  const bool first = stats.presence == hal::Presence::present && stats.lost == 0;
  const std::string words = first ? "measuring before " + camera_.name : apps::camera_words(stats, camera_);
  log(stats.presence == hal::Presence::present ? Level::notice : Level::warning, words);
  status(words);
  say(apps::camera_event(stats, camera_));
}

Status Daemon::measure_people(hal::Source& source) {
  auto engine = apps::make_engine(config_.measuring, data_, camera_, [this](const FrameSeen& frame) { see(frame); });
  if (!engine) return engine.error();
  engine_ = std::move(*engine);
  if (auto started = source.start(); !started) return started;
  Status status = Ok{};
  bool ended = false;
  while (status && !ended && !end_requested()) {
    if (status = serve_clients(&source); !status) break;
    const auto pumped = take_frame(source);
    feed_watchdog(source.lost());
    if (!pumped) {
      status = pumped.error();
    } else if (*pumped == Pumped::frame) {
      ++frames_;
      if (consented_) status = handle_result(source);
      send_masks();
    } else if (*pumped == Pumped::end) {
      ended = true;
    }
  }
  source.stop();
  if (!status || !ended || !consented_) return status;
  engine_->finish();
  return handle_result(source);
}

// Without consent a camera's frames are taken unseen, and a recording waits.
Result<Pumped> Daemon::take_frame(hal::Source& source) {
  if (consented_) return pump(source, *engine_, kWaitMs);
  if (!source.info().live) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kWaitMs));
    processed_.fetch_add(1, std::memory_order_relaxed);
    return Pumped::waiting;
  }
  Unseen unseen(unseen_, source.info().intrinsics);
  auto pumped = pump(source, unseen, kWaitMs);
  if (pumped && *pumped == Pumped::frame) processed_.fetch_add(1, std::memory_order_relaxed);
  return pumped;
}

// On the engine's thread.
void Daemon::see(const FrameSeen& frame) {
  processed_.fetch_add(1, std::memory_order_relaxed);
  frame_ns_ = frame.info.host_ns;
  // Once the view was empty for too long nobody renews the consent: who comes then has not given it.
  const std::int64_t since_ns = in_view_ns_, now_ns = frame.info.host_ns;
  const std::int64_t most_ns = std::int64_t{1'000'000'000} * config_.consent_absent_s;
  if (since_ns < 0 || (frame.result.user != 0 && now_ns - since_ns <= most_ns)) in_view_ns_ = now_ns;
  const std::lock_guard lock(masks_.mutex);
  if (!masks_.wanted || frame.mask.pixels == nullptr) return;
  masks_.wanted = false;
  masks_.taken = true;
  masks_.width = frame.mask.width;
  masks_.height = frame.mask.height;
  masks_.user = frame.result.user;
  masks_.sequence = frame.info.sequence;
  masks_.pixels.clear();
  for (int v = 0; v < frame.mask.height; ++v)
    masks_.pixels.insert(masks_.pixels.end(), frame.mask.row(v), frame.mask.row(v) + frame.mask.width);
}

Status Daemon::handle_result(const hal::Source& source) {
  const EngineResult result = engine_->result();
  if (result.session != session_) {
    session_ = result.session;
    erased_ = false;
    if (std::exchange(reported_, false)) {
      say(apps::left_event(frames_, persons_));
      if (config_.consent_ask) {
        end_consent();
        return Ok{};
      }
    }
    // The same person, begun anew.
    if (facts_)
      if (auto set = engine_->set_known(*facts_, session_); !set) return set;
  }
  if (const auto shown = apps::shown_state(result); shown != shown_) {
    shown_ = shown;
    say(apps::state_event(frames_, result));
  }
  watch_consent();
  if (apps::is_stuck(result)) engine_->next_person();
  if (!consented_) return Ok{};
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
  body_ = person->body;
  const std::string text = full_result_json(*person, data_);
  say(apps::measured_event(frames_, persons_, text));
  keep(text);
  return Ok{};
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
  std::string lines = apps::line_of({{"event", "hello"},
                                     {"protocol", "im2fitd/1"},
                                     {"version", IM2FIT_VERSION},
                                     {"persons", persons_},
                                     {"commands", kCommands}});
  for (const apps::Json* event : {&visit_event_, &camera_event_, &state_event_})
    if (!event->is_null()) lines += apps::line_of(*event);
  return lines;
}

void Daemon::say(const apps::Json& event) {
  if (event["event"] == "camera") camera_event_ = event;
  if (event["event"] == "state") state_event_ = event;
  if (event["event"] == "visit") visit_event_ = event;
  publisher_->publish(apps::line_of(event));
}

}  // namespace im2fit::daemon
