// SPDX-License-Identifier: Apache-2.0
// The service itself: measures one person after the other before a source, and talks with the clients of its socket.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/events.h"
#include "apps/common/measuring.h"
#include "apps/im2fitd/commands.h"
#include "apps/im2fitd/config.h"
#include "apps/im2fitd/notify.h"
#include "apps/im2fitd/publisher.h"
#include "hal/open/open.h"
#include "hal/source.h"

namespace im2fit::daemon {

inline constexpr char kNoCamera[] = "no camera is present, so nobody is measured";

// What signals ask for; set by their handlers.
struct SignalWishes {
  static inline std::atomic<bool> stop{false};    // SIGTERM, SIGINT
  static inline std::atomic<bool> reload{false};  // SIGHUP
};

class Daemon {
 public:
  // `config_path` is read again at SIGHUP. Loads all data and makes the socket. Errors: those of its parts.
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
  Result<Pumped> take_frame(hal::Source& source);
  Status handle_result(const hal::Source& source);
  Status report_person(const hal::Source& source);
  Status say_person(const EngineResult& result, const hal::Source& source);
  void see(const FrameSeen& frame);

  // Clients: daemon_commands.cpp.
  Status serve_clients(const hal::Source* source);
  bool handle_line(const ClientLine& line, const hal::Source* source);
  // What is wrong with the command now; nothing: it was done. `corrected`: of a person who is measured already.
  std::optional<std::string> obey(const ClientLine& line, const Command& command, bool& corrected);
  std::optional<std::string> take_facts(const Command& command, bool& corrected);
  std::optional<std::string> take_consent(const Command& command);
  std::optional<std::string> select_user(const Command& command);
  std::optional<std::string> send_avatar(const ClientLine& line, const Command& command);
  void begin_anew();
  std::optional<std::string> erase(const Command& command);
  std::string erase_kept();
  void send_users(const ClientLine& line, const Command& command);
  void send_masks();
  void end_consent();
  void watch_consent();
  void refuse(std::uint64_t client, const std::string& reason, const apps::Json& id);

  void keep(const std::string& result);
  void feed_watchdog(bool waiting);
  std::string greeting() const;
  void say(const apps::Json& event);
  void status(const std::string& text) const { notifier_.send("STATUS=" + text); }

  // A mask that clients wait for: asked for here, taken on the engine's thread.
  struct Masks {
    std::mutex mutex;
    std::vector<std::pair<std::uint64_t, apps::Json>> clients;  // and their ids
    bool wanted = false, taken = false;
    std::vector<std::uint8_t> pixels;
    int width = 0, height = 0, user = 0;
    std::uint64_t sequence = 0;
  };

  Config config_;
  std::string config_path_;
  Notifier& notifier_;
  MeasuringData data_;
  std::string state_directory_;
  std::unique_ptr<Publisher> publisher_;
  Masks masks_;
  std::atomic<std::uint64_t> processed_{0};  // frames out of the engine, and those left out without consent
  std::unique_ptr<Engine> engine_;
  std::uint64_t processed_when_fed_ = 0;
  hal::SourceInfo camera_;
  apps::Json camera_event_;
  apps::Json state_event_;
  apps::Json visit_event_;
  std::optional<Config> reloaded_;
  std::optional<apps::ShownState> shown_;
  std::optional<KnownFacts> facts_;    // of the person who is measured next
  std::optional<AnsweredBody> body_;   // of the person measured last
  std::vector<std::uint16_t> unseen_;  // of a frame that no one has consented to
  std::uint64_t frames_ = 0;
  std::uint32_t session_ = 0;
  int persons_ = 0;
  // By the frames' times: of the latest one, and when the person who consented was in view last; -1: no frame yet.
  std::atomic<std::int64_t> frame_ns_{-1}, in_view_ns_{-1};
  bool consented_ = true;  // frames are processed
  bool reported_ = false;
  bool erased_ = false;  // of a person who is still in view
  bool keeping_fails_ = false;
};

}  // namespace im2fit::daemon
