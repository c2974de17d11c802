// SPDX-License-Identifier: Apache-2.0
// A run in a browser: the camera's picture, the guidance, the measured person, and their body, which follows them.
// Each visit belongs to one person: no frame is used before consent, and a result goes for every client at once.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include "apps/common/events.h"
#include "apps/common/reported_facts.h"
#include "apps/kiosk/avatar_animator.h"
#include "apps/kiosk/board.h"
#include "apps/kiosk/chores.h"
#include "apps/kiosk/fitting_room.h"
#include "apps/kiosk/hand_over.h"
#include "apps/kiosk/operator_desk.h"
#include "apps/kiosk/page_server.h"
#include "apps/kiosk/shop_file.h"
#include "apps/kiosk/statistics.h"
#include "apps/kiosk/visit.h"
#include "engine/engine.h"

namespace im2fit::apps {

struct LivePageSettings {
  PageAddress address;
  VisitRules visit;
  std::string body_path;     // the body file with which /tryon.glb is made; "": it is not
  bool keeps_files = false;  // a result is written elsewhere as well: consent has to say so
  // On the server's thread. A person consented, to which text: "en-1".
  std::function<void(std::uint64_t visit, const std::string& text)> consented;
  // A person requested deletion, or consent ended before the result came: delete the files written to this folder,
  // too.
  std::function<void(const std::string& folder)> erase_folder;
  std::optional<OperatorSettings> desk;  // the operator's part of the page; nullopt: none
  std::string operator_password;         // needed with `desk`
  std::optional<Shop> shop;              // whose page it is; none: nobody is named
  std::string statistics_path;           // file of statistics.h; "": nothing is counted
  // Where phones take results that the page hands over, and nothing else; none: it hands none over.
  std::optional<PageAddress> hand_over;
  std::chrono::milliseconds hand_over_max = kHandOverMax;
};

// `see` on the engine's thread, the rest on one other. Nothing is drawn while no browser watches.
class LivePage {
 public:
  // Errors: as PageServer::open(), Statistics::open().
  static Result<std::unique_ptr<LivePage>> open(const LivePageSettings& settings);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;
  const std::string& url() const { return server_->url(); }
  int watchers() const { return server_->watchers(); }                     // pages that follow it now
  std::string phone_url() const { return phones_ ? phones_->url() : ""; }  // "": no phone is handed anything

  // What keeps people from being measured: "NO_CAMERA", "MODELS_MISSING", "FAILED"; "": nothing.
  void trouble(std::string_view code);
  // Before the first frame.
  void begin(const Intrinsics& intrinsics, int frames_wanted);
  // As those of LiveListener.
  std::uint64_t permit();
  void begin_person(std::uint64_t permit);
  void see(const FrameSeen& frame);
  void publish(const Json& event);
  // What the operator's part writes into sessions. Before begin().
  void use_source(const hal::SourceInfo& source, const sessions::Versions& versions,
                  DiagnosePicture diagnose = nullptr) {
    if (desk_) desk_->use_source(source, versions, std::move(diagnose));
  }
  // As the operator set it.
  OperatorRegion region() const { return desk_ ? desk_->region() : OperatorRegion{}; }
  // What the person of this visit reported last; `count` 0: nothing, or the visit is over.
  ReportedFacts reported(std::uint64_t visit);
  // Before its event, `measured`.
  Status measured(const body::Avatar& avatar, std::span<const std::byte> glb);
  // Before its event too. The visit is the current one.
  void may_try_on(Customer customer);

 private:
  using Clock = std::chrono::steady_clock;
  explicit LivePage(const LivePageSettings& settings);
  // These hold visit_mutex_, but not while a recording is deleted: the engine's frames need it, and a disk may be
  // slow. Deletions are chores: neither the server's thread nor the keeper waits for them.
  PageAnswer act(PageAction action, std::string_view visit, std::string_view note);
  PageAnswer offer(std::string_view visit);
  PageAnswer take(std::string_view token);
  PageAnswer take_facts(std::string_view visit, std::string_view body);
  void tick();
  bool begin_recorded_visit(const std::function<void(std::uint64_t visit)>& begun);
  void end_recorded_visit(std::uint64_t visit);
  // These need it held.
  void publish_visit();
  void publish_beat();
  // The visit that is over: all of it that the page has, for every client.
  void forget();
  OperatorDesk::Deletion give_up_recording(std::uint64_t visit, bool erased);  // as OperatorDesk::visit_over
  void next_visit();
  bool publish_of_visit(const std::string& kind, const Json& event, std::string line);
  bool is_current() const { return permitted_ == visit_.number(); }

  // Of the visit that goes on, for the statistics.
  void count_guidance(GuidanceSet guidance);
  void count_end();
  void draw(const FrameSeen& frame);
  void move(const FrameSeen& frame);

  const LivePageSettings settings_;
  const std::string boot_ = random_id();
  Board board_;
  Intrinsics intrinsics_;
  std::mutex visit_mutex_;
  Visit visit_;
  std::uint64_t permitted_ = 0;  // the visit whose frames the engine works on
  bool follows_ = false;         // the measured person is still in view
  std::string folder_;           // the folder written for this visit
  ReportedFacts reported_;       // of this visit
  std::uint32_t reports_ = 0;    // of all visits
  bool corrects_ = false;        // the run that measured the person goes on: facts can still be corrected
  std::optional<AvatarAnimator> animator_;
  std::chrono::steady_clock::time_point drawn_{};
  std::uint64_t pictures_ = 0;
  bool ending_ = false;
  bool counts_ = false;                                    // a customer's visit goes on that has no answer yet
  std::array<std::uint64_t, kGuidanceCount> kept_from_{};  // its frames by guidance
  Customer customer_;                                      // the next measured person to try on clothes
  std::unique_ptr<FittingRoom> fitting_;                   // null: nothing is tried on
  std::unique_ptr<Statistics> statistics_;                 // null: nothing is counted
  std::unique_ptr<OperatorDesk> desk_;                     // null: no operator
  std::uint64_t desk_visit_ = 0;                           // the last visit that the operator began
  std::thread keeper_;
  Chores chores_;  // deletions
  HandOver hand_over_;
  Board phone_board_;  // the shop's name, colours and logo
  // Last: they refer to the boards, the fitting room and the desk.
  std::unique_ptr<PageServer> phones_;  // null: no phone is handed anything
  std::unique_ptr<PageServer> server_;
};

}  // namespace im2fit::apps
