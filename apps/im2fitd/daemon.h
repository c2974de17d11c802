// SPDX-License-Identifier: Apache-2.0
// Measures one person after the other before a camera and publishes at the socket, until it is stopped.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "apps/common/events.h"
#include "apps/common/measuring.h"
#include "apps/im2fitd/config.h"
#include "apps/im2fitd/notify.h"
#include "apps/im2fitd/publisher.h"
#include "hal/source.h"

namespace im2fit::daemon {

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
  std::uint64_t frames_ = 0;
  std::uint32_t session_ = 0;
  int persons_ = 0;
  bool reported_ = false;
  bool keeping_fails_ = false;
};

}  // namespace im2fit::daemon
