// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/live_page.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "apps/common/facts_form.h"
#include "apps/common/program.h"
#include "apps/kiosk/hand_over.h"
#include "apps/kiosk/small_picture.h"
#include "formats/json_file.h"
#include "report/drawn_bones.h"

namespace im2fit::apps {
namespace {

constexpr auto kPicturePeriod = std::chrono::milliseconds(100);
constexpr auto kTickPeriod = std::chrono::milliseconds(100);
constexpr int kTicksPerBeat = 10;  // a page that hears nothing for three beats says that the program is gone

// To a tenth of a millimetre: the page needs no more.
template <class Values>
Json rounded(const Values& values) {
  Json list = Json::array();
  for (const float v : values) list.push_back(std::round(static_cast<double>(v) * 1e4) / 1e4);
  return list;
}
Json rounded(Vec3f v) {
  return rounded(std::array{v.x, v.y, v.z});
}

// Of a joint in the picture, in thousandths of its width and height.
Json in_picture(const Intrinsics& k, Vec3f p) {
  return {std::lround(1000 * (k.fx * p.x / p.z + k.cx) / static_cast<float>(k.width)),
          std::lround(1000 * (k.fy * p.y / p.z + k.cy) / static_cast<float>(k.height))};
}

bool all_finite(const JointSet& joints) {
  return std::all_of(joints.position_mm.begin(), joints.position_mm.end(), [](const Vec3f& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && p.z > 0;
  });
}

}  // namespace

LivePage::LivePage(const LivePageSettings& settings)
    : settings_(settings), visit_(settings.visit, Clock::now()), hand_over_(settings.hand_over_max) {}

Result<std::unique_ptr<LivePage>> LivePage::open(const LivePageSettings& settings) {
  std::unique_ptr<LivePage> page(new LivePage(settings));
  LivePage& self = *page;
  if (!settings.statistics_path.empty()) {
    auto statistics = Statistics::open(settings.statistics_path);
    if (!statistics) return statistics.error();
    self.statistics_ = std::move(*statistics);
  }
  for (Board* board : {&self.board_, &self.phone_board_}) {
    board->put("/shop.css", {"text/css; charset=utf-8", settings.shop ? shop_css(*settings.shop) : ""});
    if (settings.shop && !settings.shop->logo.empty()) board->put("/shop.png", {"image/png", settings.shop->logo});
  }
  // On the board for phones alone: a screen has it from its hello. Not the consent's words: nobody agrees there.
  Json brand;
  if (settings.shop) brand = {{"name", settings.shop->name}, {"logo", !settings.shop->logo.empty()}};
  self.phone_board_.put("/shop.json", {"application/json", brand.dump()});
  self.begin({}, 0);
  self.publish_visit();
  PageHandlers handlers;
  handlers.act = [&self](PageAction action, std::string_view visit, std::string_view note) {
    return self.act(action, visit, note);
  };
  if (!settings.body_path.empty()) {
    self.fitting_ = std::make_unique<FittingRoom>(
        settings.body_path,
        [&self](const std::string& visit) {
          self.board_.publish("tryon", Json{{"event", "tryon"}, {"visit", visit}}.dump());
        },
        [&self](std::uint32_t number) {
          self.board_.publish("cloth", Json{{"event", "cloth"}, {"number", number}}.dump());
        });
    handlers.try_on = [&self](auto fields) { return self.fitting_->ask(fields); };
    handlers.cloth = [&self](auto fields) { return self.fitting_->ask_cloth(fields); };
  }
  if (settings.desk) {
    self.desk_ = std::make_unique<OperatorDesk>(*settings.desk, settings.shop, self.statistics_.get());
    self.desk_->use_visits([&self](const auto& begun) { return self.begin_recorded_visit(begun); },
                           [&self](std::uint64_t visit) { self.end_recorded_visit(visit); });
    handlers.operate = [&self](const PageRequest& request) { return self.desk_->answer(request); };
    handlers.operator_password = settings.operator_password;
  }
  if (settings.visit.ask_facts)
    handlers.facts = [&self](std::string_view visit, std::string_view body) { return self.take_facts(visit, body); };
  if (settings.hand_over) {
    handlers.offer = [&self](std::string_view visit) { return self.offer(visit); };
    PageHandlers of_phones;
    of_phones.take = [&self](std::string_view token) { return self.take(token); };
    auto phones = PageServer::open(*settings.hand_over, self.phone_board_, std::move(of_phones));
    if (!phones) return phones.error();
    self.phones_ = std::move(*phones);
  }
  auto server = PageServer::open(settings.address, self.board_, std::move(handlers));
  if (!server) return server.error();
  self.server_ = std::move(*server);
  self.keeper_ = std::thread([&self] { self.tick(); });
  return page;
}

LivePage::~LivePage() {
  {
    const std::lock_guard lock(visit_mutex_);
    ending_ = true;
  }
  if (keeper_.joinable()) keeper_.join();
  if (!statistics_) return;
  const std::lock_guard lock(visit_mutex_);
  count_end();
  if (const auto written = statistics_->flush(); !written) print_error(written.error().message);
}

void LivePage::begin(const Intrinsics& intrinsics, int frames_wanted) {
  {
    const std::lock_guard lock(visit_mutex_);
    intrinsics_ = intrinsics;
    follows_ = corrects_ = false;
  }
  Json bones = Json::array();
  for (const DrawnBone& bone : kDrawnBones)
    bones.push_back({static_cast<int>(bone.from), static_cast<int>(bone.to), static_cast<int>(bone.coloured_as)});
  board_.publish("hello", Json{{"event", "hello"},
                               {"boot", boot_},
                               {"asks", settings_.visit.ask},
                               {"asks_facts", settings_.visit.ask_facts},
                               {"keeps_files", settings_.keeps_files},
                               {"counts", statistics_ != nullptr},
                               {"hands_over", settings_.hand_over.has_value()},
                               {"frames_wanted", frames_wanted},
                               {"joints", kJointNames},
                               {"bones", bones},
                               {"segments", body::kSegmentNames},
                               {"shop", settings_.shop ? shop_json(*settings_.shop) : Json()}}
                              .dump());
}

void LivePage::trouble(std::string_view code) {
  if (!code.empty()) {
    const std::lock_guard lock(visit_mutex_);
    corrects_ = false;
  }
  board_.publish("trouble", Json{{"event", "trouble"}, {"code", code}}.dump());
}

void LivePage::publish_visit() {
  board_.publish("visit", Json{{"event", "visit"},
                               {"id", visit_.id()},
                               {"state", name_of(visit_.state())},
                               {"recorded", visit_.number() == desk_visit_}}
                              .dump());
  publish_beat();
}

// A kind of its own: a page that comes later hears of the visit before it hears of its result.
void LivePage::publish_beat() {
  const auto left = visit_.left(Clock::now());
  board_.publish("beat", Json{{"event", "beat"}, {"left_s", (left.count() + 999) / 1000}}.dump());
}

bool LivePage::begin_recorded_visit(const std::function<void(std::uint64_t visit)>& begun) {
  const std::lock_guard lock(visit_mutex_);
  const auto now = Clock::now();
  if (visit_.state() != VisitState::asking) {
    if (visit_.number() != desk_visit_) return false;  // a customer's
    visit_.next(now);
    forget();  // its recording is saved or discarded: the desk would not begin another
  }
  if (!visit_.consent(visit_.id(), now)) return false;
  visit_.facts_done(now);  // the tape is compared with what the camera measured, without them
  desk_visit_ = visit_.number();
  begun(desk_visit_);
  publish_visit();
  return true;
}

void LivePage::end_recorded_visit(std::uint64_t visit) {
  OperatorDesk::Deletion deletion;
  {
    const std::lock_guard lock(visit_mutex_);
    if (visit_.number() != visit || visit_.state() == VisitState::asking) return;
    visit_.next(Clock::now());
    forget();
    deletion = give_up_recording(visit, true);
  }
  if (deletion) (void)deletion();
}

OperatorDesk::Deletion LivePage::give_up_recording(std::uint64_t visit, bool erased) {
  return desk_ ? desk_->visit_over(visit, erased) : nullptr;
}

void LivePage::count_guidance(GuidanceSet guidance) {
  if (!counts_) return;
  for (std::size_t i = 0; i < kGuidanceCount; ++i) kept_from_[i] += guidance >> i & 1U;
}

// Without an answer: what most frames asked for, but that somebody be there, which all ask for once they have left.
void LivePage::count_end() {
  if (!std::exchange(counts_, false)) return;
  constexpr auto kNobody = static_cast<std::size_t>(std::countr_zero(static_cast<GuidanceSet>(Guidance::no_person)));
  kept_from_[kNobody] = 0;
  const auto most = std::max_element(kept_from_.begin(), kept_from_.end());
  const auto code = kGuidanceNames[static_cast<std::size_t>(most - kept_from_.begin())];
  statistics_->not_measured(local_day(), *most == 0 ? "LEFT" : std::string(code));
}

void LivePage::forget() {
  count_end();
  // Files first: who hears of the new visit finds nothing of the one before.
  board_.withdraw({"state", "frame", "picture", "measured", "tryon", "cloth", "left"},
                  {"/result.json", "/avatar.glb", "/picture.png"});
  if (fitting_) fitting_->forget();
  hand_over_.forget();
  animator_.reset();
  follows_ = corrects_ = false;
  folder_.clear();
  reported_ = {};
  publish_visit();
}

PageAnswer LivePage::act(PageAction action, std::string_view visit, std::string_view note) {
  const PageAnswer over{409, nullptr, "that visit is over"};
  std::string folder;
  OperatorDesk::Deletion deletion;
  {
    const std::lock_guard lock(visit_mutex_);
    const auto now = Clock::now();
    const std::uint64_t number = visit_.number();
    switch (action) {
      case PageAction::touch:
        if (!visit_.touch(visit, now)) return over;
        publish_beat();
        break;
      case PageAction::consent:
        if (!visit_.consent(visit, now)) return over;
        publish_visit();
        if (statistics_) {
          statistics_->visit(local_day());
          counts_ = true;
          kept_from_ = {};
        }
        if (settings_.consented) settings_.consented(visit_.number(), std::string(note));
        break;
      case PageAction::erase:
        folder = folder_;
        if (!visit_.erase(visit, now)) return over;
        forget();
        deletion = give_up_recording(number, true);
        break;
    }
  }
  if (action != PageAction::erase) return {200, nullptr, "done"};
  return chores_.run([this, folder, deletion = std::move(deletion)]() -> PageAnswer {
    if (!folder.empty() && settings_.erase_folder) settings_.erase_folder(folder);
    if (const Status gone = deletion ? deletion() : Status(Ok{}); !gone)
      return {500, nullptr, "the recording was not deleted: " + gone.error().message};
    return {200, nullptr, "done"};
  });
}

// Only the page that requested the code receives it.
PageAnswer LivePage::offer(std::string_view visit) {
  const std::lock_guard lock(visit_mutex_);
  const auto now = Clock::now();
  auto result = board_.file("/result.json");
  if (!result || visit_.state() != VisitState::result || !visit_.touch(visit, now))
    return {409, nullptr, "this visit has no result, or is over"};
  publish_beat();
  // The part behind '#' is never sent: neither a proxy nor a program that previews links takes the result.
  const std::string address = phones_->url() + "#" + hand_over_.offer(std::move(result), now);
  const auto code = qr_code(address);
  if (!code) return {500, nullptr, code.error().message};
  // What it is good for at least; touches put the end of the visit off.
  const auto of_visit = visit_.left(now);
  const auto left = of_visit.count() > 0 ? std::min(of_visit, settings_.hand_over_max) : settings_.hand_over_max;
  const Json json = {
      {"address", address}, {"left_s", left.count() / 1000}, {"side", code->side}, {"path", code->path}};
  return {200, std::make_shared<const PageFile>(PageFile{"application/json", json_text(json)}), ""};
}

PageAnswer LivePage::take(std::string_view token) {
  const std::lock_guard lock(visit_mutex_);
  auto result = hand_over_.take(token, Clock::now());
  if (!result) return {404, nullptr, "not found, or fetched already"};
  return {200, std::move(result), ""};
}

PageAnswer LivePage::take_facts(std::string_view visit, std::string_view body) {
  const auto facts = facts_of_form(body);
  if (!facts) return {400, nullptr, facts.error().message};
  const std::lock_guard lock(visit_mutex_);
  const auto now = Clock::now();
  if (!visit_.touch(visit, now)) return {409, nullptr, "that visit is over"};
  if (visit_.state() == VisitState::asking) return {409, nullptr, "the person has not consented"};
  if (visit_.number() == desk_visit_) return {409, nullptr, "a visit that the operator records takes no facts"};
  if (visit_.state() == VisitState::result && !corrects_)
    return {409, nullptr, "this result can no longer be changed: the recording or the camera's run is over"};
  reported_ = {++reports_, *facts};
  if (visit_.facts_done(now)) publish_visit();
  return {202, nullptr, "taken"};
}

ReportedFacts LivePage::reported(std::uint64_t visit) {
  const std::lock_guard lock(visit_mutex_);
  return visit == visit_.number() ? reported_ : ReportedFacts{};
}

void LivePage::tick() {
  bool statistics_failed = false;
  for (int ticks = 0;; ++ticks) {
    OperatorDesk::Deletion deletion;  // of the visit that time has ended
    {
      const std::lock_guard lock(visit_mutex_);
      if (ending_) return;
      const std::uint64_t number = visit_.number();
      if (visit_.tick(Clock::now())) {
        forget();
        deletion = give_up_recording(number, false);
      } else if (ticks % kTicksPerBeat == 0) {
        publish_beat();
      }
    }
    if (deletion)
      chores_.run([deletion = std::move(deletion)]() -> PageAnswer {
        (void)deletion();
        return {};
      });
    if (statistics_ && ticks % kTicksPerBeat == 0)
      if (const auto written = statistics_->flush(); !written && !std::exchange(statistics_failed, true))
        print_error(written.error().message + "; visits are counted on and written when that works");
    std::this_thread::sleep_for(kTickPeriod);
  }
}

std::uint64_t LivePage::permit() {
  const std::lock_guard lock(visit_mutex_);
  const bool open = visit_.state() == VisitState::measuring || (visit_.state() == VisitState::result && follows_);
  if (!settings_.visit.ask) {
    permitted_ = visit_.number();
    return 1;
  }
  return open ? visit_.number() : 0;
}

void LivePage::begin_person(std::uint64_t permit) {
  const std::lock_guard lock(visit_mutex_);
  if (!settings_.visit.ask) return;  // the next person ends the visit before: publish_of_visit()
  permitted_ = permit;
  if (desk_) desk_->begin_anew(permit);
}

void LivePage::see(const FrameSeen& frame) {
  std::uint64_t visit = 0;
  {
    const std::lock_guard lock(visit_mutex_);
    if (frame.result.user != 0) visit_.person_in_view(Clock::now());
    if (!is_current()) return;  // of the visit before
    visit = visit_.number();
    count_guidance(frame.result.guidance);
  }
  if (desk_) {
    desk_->see(visit, frame);
    desk_->look(visit, frame);
  }
  if (server_->watchers() == 0) return;
  move(frame);
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < kPicturePeriod) return;
  drawn_ = now;
  draw(frame);
}

void LivePage::move(const FrameSeen& frame) {
  const EngineResult& result = frame.result;
  Json event = {{"event", "frame"}, {"frames_used", result.frames_used}, {"frames_back", result.frames_back}};
  if (is_all_round(result.turn)) event["turned_deg"] = std::lround(std::fabs(result.turned_deg));
  const std::lock_guard lock(visit_mutex_);
  if (result.has_joints && all_finite(result.display_joints)) {
    Json joints = Json::array(), pixels = Json::array();
    for (const Vec3f& p : standing_joints_m(result.display_joints, result.floor)) joints.push_back(rounded(p));
    for (const Vec3f& p : result.display_joints.position_mm) pixels.push_back(in_picture(intrinsics_, p));
    event["joints"] = std::move(joints);
    event["pixels"] = std::move(pixels);
    if (desk_) {
      Json percent = Json::array();
      for (const float share : result.display_joints.confidence) percent.push_back(std::lround(100 * share));
      event["confidence"] = std::move(percent);
    }
    if (animator_ && follows_) {
      const body::Pose pose = animator_->pose(result.display_joints, result.floor);
      if (fitting_) fitting_->follow(pose);
      const body::RigPose rig = animator_->rig(pose);
      event["root"] = rounded(rig.root_m);
      for (const auto& rotation : rig.rotation) event["rotations"].push_back(rounded(rotation));
    }
  }
  if (is_current()) board_.publish("frame", event.dump());
}

void LivePage::draw(const FrameSeen& frame) {
  auto png = small_picture(frame.depth, frame.mask);
  if (!png) return;  // the next one may do
  const std::lock_guard lock(visit_mutex_);
  if (!is_current()) return;
  board_.put("/picture.png", {"image/png", std::move(*png)});
  board_.publish("picture", Json{{"event", "picture"}, {"number", ++pictures_}}.dump());
}

void LivePage::publish(const Json& event) {
  const std::string kind = event["event"];
  std::string line = line_of(event);
  line.pop_back();
  if (kind == "end") {
    const std::lock_guard lock(visit_mutex_);
    corrects_ = false;
  }
  if (kind == "camera" || kind == "end") {  // without the result of the last frame
    board_.publish(kind, kind == "end" ? R"({"event":"end"})" : std::move(line));
    return;
  }
  bool shown = false;
  {
    const std::lock_guard lock(visit_mutex_);
    shown = publish_of_visit(kind, event, std::move(line));
  }
  if (!shown && kind == "measured" && event.contains("out") && settings_.erase_folder)
    settings_.erase_folder(event["out"]);
}

// False: of a visit that was deleted, or given up, while this was computed.
bool LivePage::publish_of_visit(const std::string& kind, const Json& event, std::string line) {
  // Without a question, the next person ends the visit before.
  if (!settings_.visit.ask && visit_.state() == VisitState::result && !follows_ &&
      (kind == "measured" || (kind == "state" && event["user"] != 0)))
    next_visit();
  if (!is_current()) {
    if (kind == "measured") customer_ = {};
    return false;
  }
  if (kind == "measured") {
    if (event.value("corrected", false)) {
      if (visit_.state() != VisitState::result) return false;
      hand_over_.forget();  // its code is of the result before
    } else {
      if (!visit_.measured(Clock::now())) return false;
      follows_ = corrects_ = true;
      if (std::exchange(counts_, false)) {
        const Json& result = event["result"];
        statistics_->measured(local_day(), result.contains("size") ? result["size"].value("best", "") : "");
      }
    }
    folder_ = event.value("out", std::string());
    board_.put("/result.json", {"application/json", event["result"].dump(2) + "\n"});
    customer_.visit = visit_.id();
    if (fitting_) fitting_->welcome(std::exchange(customer_, {}));
    publish_visit();
    if (desk_) desk_->measured(visit_.number(), event["result"].dump(2) + "\n");
  }
  if (kind == "left") follows_ = false;  // the next person's joints are not theirs
  board_.publish(kind, std::move(line));
  return true;
}

void LivePage::next_visit() {
  visit_.next(Clock::now());
  permitted_ = visit_.number();
  forget();  // there is no desk without a question
}

void LivePage::may_try_on(Customer customer) {
  const std::lock_guard lock(visit_mutex_);
  customer_ = std::move(customer);
}

Status LivePage::measured(const body::Avatar& avatar, std::span<const std::byte> glb) {
  auto animator = AvatarAnimator::create(avatar);
  if (!animator) return animator.error();
  const std::lock_guard lock(visit_mutex_);
  if (!settings_.visit.ask && visit_.state() == VisitState::result) next_visit();
  if (!is_current()) return Ok{};  // deleted, or given up, while it was computed
  board_.put("/avatar.glb",
             {"model/gltf-binary", std::string(reinterpret_cast<const char*>(glb.data()), glb.size())});
  animator_ = *animator;
  return Ok{};
}

}  // namespace im2fit::apps
