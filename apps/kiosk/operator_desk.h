// SPDX-License-Identifier: Apache-2.0
// The operator's part of the page: one person's visit recorded with the tape readings, saved as a session, and the
// list of sessions. Answers everything below /operator/; page_server.h checks the access.
//
//   IDLE -> (consent) RECORDING -> (the engine's answer) MEASURED -> (saved, discarded, deleted by the person) IDLE
//
// The person's own page shows that they are recorded, and its Delete also deletes the saved session.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "apps/common/events.h"
#include "apps/common/operator_region.h"
#include "apps/kiosk/chores.h"
#include "apps/kiosk/floor_plan.h"
#include "apps/kiosk/page_server.h"
#include "apps/kiosk/shop_file.h"
#include "apps/kiosk/statistics.h"
#include "apps/kiosk/visit_recorder.h"
#include "hal/depth_diagnosis.h"

namespace im2fit::apps {

// The texts a person agrees to before they are recorded: those of web/lang/*.json, known by their digest.
struct ConsentText {
  const char* language;  // "de"
  const char* version;   // "1"
  const char* sha256;    // of its title and points in UTF-8, a line feed between them
};
const ConsentText* consent_text(std::string_view language);  // null: there is none

// Why a picture shows no person (engine/diagnosis.h). Some tenths of a second.
using DiagnosePicture = std::function<hal::DepthDiagnosis(DepthView depth)>;

struct OperatorSettings {
  std::string root;  // of the sessions
  std::string site;  // proposed in the form
  // As the engine measures: written into each session. A region that it has is the command line's: the page shows it,
  // and cannot change it.
  sessions::Settings settings;
  // Measurements a tape may take, with their names by language.
  std::vector<std::pair<std::string, Json>> tape;
  // A session's recording measured again: {"then": result.json, "now": result.json}. Some seconds; on a thread of its
  // own.
  std::function<Result<Json>(const std::string& id)> measure;
};

class OperatorDesk {
 public:
  // `shop` is named in the consent; `statistics` must outlive this, null: nothing is counted.
  explicit OperatorDesk(OperatorSettings settings, std::optional<Shop> shop = std::nullopt,
                        const Statistics* statistics = nullptr);
  ~OperatorDesk();
  OperatorDesk(const OperatorDesk&) = delete;
  OperatorDesk& operator=(const OperatorDesk&) = delete;

  // Begin and end a visit; set before any request. `begin` consents for the person of the present visit and calls
  // `begun` with its number before the first frame of it is seen. It returns false when another visit is going on.
  // `end` ends the visit of that number if it goes on.
  using BeginVisit = std::function<bool(const std::function<void(std::uint64_t visit)>& begun)>;
  using EndVisit = std::function<void(std::uint64_t visit)>;
  void use_visits(BeginVisit begin, EndVisit end) {
    begin_visit_ = std::move(begin);
    end_visit_ = std::move(end);
  }
  // The region kept for this camera holds from here on. `diagnose` may be null.
  void use_source(const hal::SourceInfo& source, const sessions::Versions& versions,
                  DiagnosePicture diagnose = nullptr);
  // Any thread.
  OperatorRegion region() const;
  // Of every frame of a visit, recorded or not, on the engine's thread: keeps the floor's plan, and finds out why no
  // person is seen.
  void look(std::uint64_t visit, const FrameSeen& frame);
  PageAnswer answer(const PageRequest& request);  // on the server's thread

  // Called for the visit of this number, on any thread; they do nothing for other visits.
  // The engine and the recording start again: the recording then holds the engine's frames and nothing else.
  void begin_anew(std::uint64_t visit);
  void see(std::uint64_t visit, const FrameSeen& frame);
  void measured(std::uint64_t visit, const std::string& result_json);
  // Gives the recording up: the person requested deletion, or left before there was an answer. `erased`: the person
  // requested it; then its session goes, too, if it is saved or being saved. Otherwise a measured visit is kept for
  // the operator, who is still at the form. Does not wait: another visit may begin at once. What it returns deletes
  // the files and may wait for the disk; call it once, on any thread, without a lock. Null: there are none. Its
  // errors: the session stays.
  using Deletion = std::function<Status()>;
  Deletion visit_over(std::uint64_t visit, bool erased);

 private:
  enum class Phase { idle, recording, measured };
  struct Job {
    std::string kind;  // "save", "measure"; "": there was none
    std::string id;    // of the session
    std::string error;
    Json result;
    bool running = false;
  };
  PageAnswer get(const PageRequest& request);
  PageAnswer post(const PageRequest& request, const Json& body);
  PageAnswer state() const;
  PageAnswer begin(const Json& body);
  PageAnswer save(const Json& body);
  PageAnswer discard();
  PageAnswer set_region(const Json& body);
  PageAnswer measure_again(const std::string& id);
  PageAnswer picture(const std::string& id, const std::string& number) const;
  void draw_plan(std::uint64_t visit, const FrameSeen& frame);
  void forget_plan(std::uint64_t over);  // what the visits up to this one showed; with the lock
  PageAnswer plan() const;
  Status delete_session(std::uint64_t visit, const std::string& saved);
  std::shared_ptr<VisitRecorder> recorder_of(std::uint64_t visit) const;
  void start_job(const std::string& kind, const std::string& id, std::function<void(Job&)> work);

  const OperatorSettings settings_;
  const std::optional<Shop> shop_;
  const Statistics* const statistics_;
  BeginVisit begin_visit_;
  EndVisit end_visit_;
  mutable std::mutex mutex_;  // of all below
  hal::SourceInfo source_;
  sessions::Versions versions_;
  bool has_source_ = false;
  Phase phase_ = Phase::idle;
  std::uint64_t visit_ = 0;
  std::shared_ptr<VisitRecorder> recorder_;
  sessions::Consent consent_;
  std::string started_utc_, result_;
  std::string saved_, erased_;   // sessions of `visit_`: the one saved, the one its person deleted
  OperatorRegion region_;        // its count is another for every camera
  std::string region_text_;      // of the camera; "": everywhere
  std::string region_error_;     // why the kept one does not hold
  std::string region_at_begin_;  // of the recording; after the answer another may be set
  FloorPlan plan_;
  std::uint32_t plans_ = 0;  // another for each plan; 0: of this camera there is none
  std::chrono::steady_clock::time_point planned_{};
  std::uint64_t over_ = 0;  // the last visit that is over
  DiagnosePicture diagnose_;
  hal::DepthDiagnosis diagnosis_;
  std::uint64_t looked_visit_ = 0;                   // the engine's thread alone
  std::int64_t empty_since_ns_ = 0, looked_ns_ = 0;  // no person since; the last diagnosis. The engine's thread alone
  Job job_;
  std::thread job_thread_;
  Chores chores_;  // deletions. Last: they refer to the rest
};

}  // namespace im2fit::apps
