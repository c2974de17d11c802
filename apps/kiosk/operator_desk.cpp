// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/operator_desk.h"

#include <algorithm>
#include <filesystem>

#include "apps/common/measuring.h"
#include "apps/kiosk/kept_regions.h"
#include "apps/kiosk/small_picture.h"
#include "core/file.h"
#include "formats/json_file.h"
#include "hal/folder/depth_file.h"

namespace im2fit::apps {
namespace {

constexpr std::size_t kListedMax = 500;  // the youngest
constexpr std::size_t kPictureBytesMax = std::size_t{8} << 20;
constexpr std::size_t kNumberCharactersMax = 20;
constexpr std::size_t kRegionCharactersMax = 64;
// A person who comes is found within a second; after a diagnosis the next one waits, because it takes its time.
constexpr auto kPlanPeriod = std::chrono::milliseconds(500);
constexpr auto kPlanPeopleFor = std::chrono::seconds(2);  // a plan without news shows the room alone
constexpr std::int64_t kEmptyNs = 2'000'000'000, kLookPeriodNs = 5'000'000'000;

PageAnswer said(unsigned status, const std::string& text) {
  return {status, nullptr, text};
}
PageAnswer json_answer(const Json& json) {
  return {200, std::make_shared<const PageFile>(PageFile{"application/json", json_text(json)}), ""};
}
// A request's fault is the client's, a disk's is ours.
PageAnswer failed(const Error& error) {
  if (error.code == ErrorCode::not_found) return said(404, error.message);
  return said(error.code == ErrorCode::io ? 500 : 400, error.message);
}

std::string field_of(const PageRequest& request, std::string_view name) {
  std::string value;
  for (const auto& [key, given] : request.query)
    if (key == name) value = given;
  return value;
}

std::string text_of(const Json& body, const char* key) {
  const auto found = body.find(key);
  return found != body.end() && found->is_string() ? found->get<std::string>() : "";
}

Json listed_json(const sessions::Listed& one) {
  if (!one.damage.empty()) return {{"id", one.id}, {"damage", one.damage}};
  Json json = {{"id", one.id},
               {"person", one.record.person},
               {"started_utc", one.record.started_utc},
               {"tape_values", one.record.truth.tape.size()}};
  if (one.record.truth.height_mm) json["height_mm"] = *one.record.truth.height_mm;
  return json;
}

}  // namespace

OperatorDesk::OperatorDesk(OperatorSettings settings, std::optional<Shop> shop, const Statistics* statistics)
    : settings_(std::move(settings)), shop_(std::move(shop)), statistics_(statistics) {
  sessions::sweep(settings_.root);
}

OperatorDesk::~OperatorDesk() {
  if (job_thread_.joinable()) job_thread_.join();
}

void OperatorDesk::use_source(const hal::SourceInfo& source, const sessions::Versions& versions,
                              DiagnosePicture diagnose) {
  auto kept = settings_.settings.region.empty() ? kept_region(settings_.root, source.name)
                                                : Result<std::string>(settings_.settings.region);
  const std::lock_guard lock(mutex_);
  source_ = source;
  versions_ = versions;
  has_source_ = true;
  region_text_ = kept ? *kept : "";
  region_error_ = kept ? "" : kept.error().message;
  region_ = {region_.count + 1, region_of(region_text_)};
  diagnose_ = std::move(diagnose);
  diagnosis_ = {};
  plans_ = 0;
}

OperatorRegion OperatorDesk::region() const {
  const std::lock_guard lock(mutex_);
  return region_;
}

// Of the last frame that was long enough ago: twice a second is enough for a room.
void OperatorDesk::draw_plan(std::uint64_t visit, const FrameSeen& frame) {
  Intrinsics k;
  std::uint32_t camera = 0;
  const auto now = std::chrono::steady_clock::now();
  {
    const std::lock_guard lock(mutex_);
    if (!has_source_ || (plans_ != 0 && now - planned_ < kPlanPeriod)) return;
    k = source_.intrinsics;
    camera = region_.count;
  }
  if (!frame.result.floor.known || k.width != frame.depth.width || k.height != frame.depth.height) return;
  const FloorPlan plan = floor_plan(frame.depth, frame.mask, k, frame.result.floor);
  const std::lock_guard lock(mutex_);
  // Meanwhile the visit has ended, and nothing is kept of its person; or another camera has come.
  if (visit <= over_ || camera != region_.count) return;
  plan_ = plan;
  planned_ = now;
  ++plans_;
}

PageAnswer OperatorDesk::plan() const {
  FloorPlan plan;
  bool people = false;
  {
    const std::lock_guard lock(mutex_);
    if (plans_ == 0) return said(404, "the camera has not seen the floor yet");
    plan = plan_;
    people = std::chrono::steady_clock::now() - planned_ < kPlanPeopleFor;
  }
  auto png = picture_of(plan, people);
  if (!png) return failed(png.error());
  return {200, std::make_shared<const PageFile>(PageFile{"image/png", std::move(*png)}), ""};
}

void OperatorDesk::look(std::uint64_t visit, const FrameSeen& frame) {
  draw_plan(visit, frame);
  if (std::exchange(looked_visit_, visit) != visit) empty_since_ns_ = looked_ns_ = 0;
  const std::int64_t now = frame.info.host_ns;
  if (frame.result.user != 0 || !has(frame.result.guidance, Guidance::no_person)) {
    if (std::exchange(empty_since_ns_, 0) == 0 && looked_ns_ == 0) return;
    looked_ns_ = 0;
    const std::lock_guard lock(mutex_);
    diagnosis_ = {};
    return;
  }
  if (now < looked_ns_) empty_since_ns_ = looked_ns_ = 0;  // another recording
  if (empty_since_ns_ == 0 || now < empty_since_ns_) empty_since_ns_ = now;
  if (now - empty_since_ns_ < kEmptyNs || (looked_ns_ != 0 && now - looked_ns_ < kLookPeriodNs)) return;
  looked_ns_ = now;
  DiagnosePicture diagnose;
  {
    const std::lock_guard lock(mutex_);
    diagnose = diagnose_;
  }
  if (!diagnose) return;
  hal::DepthDiagnosis found = diagnose(frame.depth);  // outside the lock: it takes its time
  const std::lock_guard lock(mutex_);
  diagnosis_ = std::move(found);
}

std::shared_ptr<VisitRecorder> OperatorDesk::recorder_of(std::uint64_t visit) const {
  const std::lock_guard lock(mutex_);
  return phase_ == Phase::recording && visit == visit_ ? recorder_ : nullptr;
}

void OperatorDesk::begin_anew(std::uint64_t visit) {
  if (const auto recorder = recorder_of(visit)) recorder->begin_anew();
}

void OperatorDesk::see(std::uint64_t visit, const FrameSeen& frame) {
  if (const auto recorder = recorder_of(visit)) recorder->see(frame);
}

void OperatorDesk::measured(std::uint64_t visit, const std::string& result_json) {
  const auto recorder = recorder_of(visit);
  if (!recorder) return;
  recorder->measured();
  const std::lock_guard lock(mutex_);
  if (phase_ != Phase::recording || visit_ != visit) return;
  phase_ = Phase::measured;
  result_ = result_json;
}

OperatorDesk::Deletion OperatorDesk::visit_over(std::uint64_t visit, bool erased) {
  const std::lock_guard lock(mutex_);
  forget_plan(visit);
  if (visit_ != visit || (phase_ != Phase::recording && !erased)) return nullptr;
  phase_ = Phase::idle;
  result_.clear();
  return [this, visit, going = std::exchange(recorder_, nullptr), saved = std::exchange(saved_, "")]() mutable {
    going.reset();
    return delete_session(visit, saved);
  };
}

// Of the room it stays.
void OperatorDesk::forget_plan(std::uint64_t over) {
  over_ = std::max(over_, over);
  diagnosis_ = {};
  std::replace(plan_.cells.begin(), plan_.cells.end(), PlanCell::person, PlanCell::unseen);
}

Status OperatorDesk::delete_session(std::uint64_t visit, const std::string& saved) {
  if (saved.empty()) return Ok{};
  Status gone = sessions::remove(settings_.root, saved);
  if (!gone && gone.error().code == ErrorCode::not_found) gone = Ok{};  // the operator was first
  const std::lock_guard lock(mutex_);
  if (gone && visit_ == visit) erased_ = saved;
  return gone;
}

PageAnswer OperatorDesk::answer(const PageRequest& request) {
  if (!request.post) return get(request);
  const auto body = parse_json<Json>(request.body, "the request");
  if (!body || !body->is_object()) return said(400, body ? "the request is not a JSON object" : body.error().message);
  return post(request, *body);
}

PageAnswer OperatorDesk::get(const PageRequest& request) {
  const std::string id = field_of(request, "id");
  if (request.path == "/operator/state") return state();
  if (request.path == "/operator/sessions") {
    const auto all = sessions::list(settings_.root);
    if (!all) return failed(all.error());
    Json json = Json::array();
    for (auto it = all->rbegin(); it != all->rend() && json.size() < kListedMax; ++it)
      json.push_back(listed_json(*it));
    return json_answer(json);
  }
  if (request.path == "/operator/session") {
    const auto record = sessions::read(settings_.root, id);
    return record ? json_answer(*parse_json<Json>(record->document, id)) : failed(record.error());
  }
  if (request.path == "/operator/picture") return picture(id, field_of(request, "number"));
  if (request.path == "/operator/plan") return plan();
  if (request.path == "/operator/statistics.csv")
    return {200,
            std::make_shared<const PageFile>(
                PageFile{"text/csv; charset=utf-8", statistics_ == nullptr ? "" : statistics_->csv()}),
            ""};
  if (request.path == "/operator/form") {
    Json tape = Json::array();
    for (const auto& [name, names] : settings_.tape) tape.push_back({{"id", name}, {"names", names}});
    return json_answer({{"site", settings_.site},
                        {"root", settings_.root},
                        {"tape", tape},
                        {"counts", statistics_ != nullptr},
                        {"shop", shop_ ? shop_json(*shop_) : Json()}});
  }
  return said(404, "not found");
}

PageAnswer OperatorDesk::post(const PageRequest& request, const Json& body) {
  if (request.path == "/operator/begin") return begin(body);
  if (request.path == "/operator/save") return save(body);
  if (request.path == "/operator/discard") return discard();
  if (request.path == "/operator/region") return set_region(body);
  const std::string id = text_of(body, "id");
  if (request.path == "/operator/measure") return measure_again(id);
  if (request.path == "/operator/delete") {
    return chores_.run([this, id] {
      const auto gone = sessions::remove(settings_.root, id);
      return gone ? said(200, "deleted") : failed(gone.error());
    });
  }
  return said(404, "not found");
}

PageAnswer OperatorDesk::state() const {
  const std::lock_guard lock(mutex_);
  constexpr const char* kNames[] = {"IDLE", "RECORDING", "MEASURED"};
  Json json = {{"phase", kNames[static_cast<int>(phase_)]}, {"ready", has_source_}};
  if (recorder_) {
    const VisitRecorder::Counts counts = recorder_->counts();
    json["recording"] = {{"frames", counts.frames},
                         {"frames_max", VisitRecorder::kFramesMax},
                         {"dropped", counts.dropped},
                         {"full", counts.full},
                         {"error", counts.error}};
  }
  json["region"] = {{"text", region_text_}, {"fixed", !settings_.settings.region.empty()}, {"error", region_error_}};
  if (plans_ != 0) json["plan"] = {plans_, std::chrono::steady_clock::now() - planned_ < kPlanPeopleFor};
  if (diagnosis_.code != hal::DiagnosisCode::none)
    json["diagnosis"] = {{"code", std::string(hal::name_of(diagnosis_.code))},
                         {"unit_mm", diagnosis_.unit_mm},
                         {"rotate_deg", diagnosis_.rotate_deg},
                         {"text", diagnosis_.text}};
  if (phase_ == Phase::measured) json["result"] = *parse_json<Json>(result_, "result.json");
  if (!erased_.empty()) json["erased"] = erased_;
  if (!job_.kind.empty())
    json["job"] = {{"kind", job_.kind},
                   {"id", job_.id},
                   {"running", job_.running},
                   {"error", job_.error},
                   {"result", job_.result}};
  return json_answer(json);
}

PageAnswer OperatorDesk::begin(const Json& body) {
  const ConsentText* text = consent_text(text_of(body, "language"));
  if (text == nullptr || text_of(body, "version") != consent_version(text->version, shop_))
    return said(409, "the consent shown is of another version; reload the page");
  hal::SourceInfo source;
  {
    const std::lock_guard lock(mutex_);
    if (!has_source_) return said(409, "no camera is connected yet");
    if (phase_ != Phase::idle) return said(409, "a person is being recorded; save or discard that first");
    source = source_;
  }
  auto recorder = VisitRecorder::begin(settings_.root, source);
  if (!recorder) return failed(recorder.error());
  const std::shared_ptr<VisitRecorder> kept = std::move(*recorder);
  const bool begun = begin_visit_([&](std::uint64_t visit) {
    const std::lock_guard lock(mutex_);
    recorder_ = kept;
    visit_ = visit;
    forget_plan(visit - 1);  // whose result may still have been on the screen
    phase_ = Phase::recording;
    saved_.clear();
    erased_.clear();
    started_utc_ = sessions::utc_now();
    region_at_begin_ = region_text_;
    consent_ = {std::string("operator-") + text->language + "-" + consent_version(text->version, shop_),
                text->language, text->sha256, started_utc_};
    if (shop_ && shop_->consent) {
      consent_.operator_name = shop_->consent->operator_name;
      consent_.purpose = shop_->consent->purpose_in(text->language);
      consent_.contact = shop_->consent->contact;
    }
  });
  if (!begun) return said(409, "a customer's visit is in progress; end it on the customer's page first");
  return said(200, "recording");
}

PageAnswer OperatorDesk::discard() {
  std::shared_ptr<VisitRecorder> going;
  std::uint64_t visit = 0;
  {
    const std::lock_guard lock(mutex_);
    if (job_.running) return said(409, "another task is running; wait until it has ended");
    if (phase_ == Phase::idle) return said(200, "discarded");
    visit = visit_;
    phase_ = Phase::idle;
    going.swap(recorder_);
    result_.clear();
  }
  end_visit_(visit);
  return chores_.run([going = std::move(going)]() mutable {
    going.reset();
    return said(200, "discarded");
  });
}

// Not while a person is recorded: the session has one region, within which it is measured again.
PageAnswer OperatorDesk::set_region(const Json& body) {
  const auto given = body.find("region");
  if (given == body.end() || !given->is_string())
    return said(400, "region is not a text; expected x0,z0,x1,z1 in metres, or an empty text for everywhere");
  const auto text = given->get<std::string>();
  if (text.size() > kRegionCharactersMax) return said(400, "region has more than 64 characters");
  if (const std::string fault = text.empty() ? "" : region_fault(text); !fault.empty()) return said(400, fault);
  std::string camera;
  {
    const std::lock_guard lock(mutex_);
    if (!settings_.settings.region.empty())
      return said(409, "--region of the command line holds; start without it to set a region here");
    if (!has_source_) return said(409, "no camera is connected yet");
    if (phase_ == Phase::recording) return said(409, "a person is being recorded; set the region after that");
    camera = source_.name;
  }
  // Outside the lock: the disk may be slow. Recordings begin on this thread alone.
  if (const auto kept = keep_region(settings_.root, camera, text); !kept) return failed(kept.error());
  const std::lock_guard lock(mutex_);
  if (source_.name != camera) return said(200, "set");  // of the camera that was there
  region_text_ = text;
  region_error_.clear();
  region_ = {region_.count + 1, region_of(text)};
  return said(200, "set");
}

PageAnswer OperatorDesk::save(const Json& body) {
  sessions::Record record;
  std::string result;
  std::shared_ptr<VisitRecorder> recorder;
  {
    const std::lock_guard lock(mutex_);
    if (job_.running) return said(409, "another task is running; wait until it has ended");
    if (phase_ != Phase::measured) return said(409, "no person has been measured yet");
    record.started_utc = started_utc_;
    record.consent = consent_;
    record.camera = {std::string(name_of(source_.sensor)),
                     source_.name,
                     source_.intrinsics.width,
                     source_.intrinsics.height,
                     source_.intrinsics.fx,
                     source_.intrinsics.fy,
                     source_.intrinsics.cx,
                     source_.intrinsics.cy};
    record.versions = versions_;
    record.settings = settings_.settings;
    record.settings.region = region_at_begin_;
    result = result_;
    recorder = recorder_;
  }
  // The form's fields go into the record of known facts, which is parsed with the limits of any session.json.
  record.id = "new";
  Json json = *parse_json<Json>(sessions::record_json(record), "the form");
  for (const char* key : {"person", "notes", "site", "truth"})
    if (body.contains(key)) json[key] = body[key];
  auto whole = sessions::parse_record(json_text(json), "the form");
  if (!whole) return said(400, whole.error().message);
  for (const auto& [id, reading] : whole->truth.tape)
    if (std::none_of(settings_.tape.begin(), settings_.tape.end(),
                     [&id = id](const auto& known) { return known.first == id; }))
      return said(400, "the form: truth.tape." + id + " is not a measurement of the tape");
  whole->document.clear();
  start_job("save", "", [this, recorder, record = std::move(*whole), result](Job& job) {
    auto saved = recorder->save(record, result);
    if (!saved) job.error = saved.error().message;
    std::unique_lock lock(mutex_);
    if (recorder_ != recorder) {  // the person deleted it meanwhile
      lock.unlock();              // a disk may be slow
      const auto gone = saved ? sessions::remove(settings_.root, *saved) : Status(Ok{});
      job.error = gone ? "the person deleted the recording" : gone.error().message;
      return;
    }
    if (saved) job.id = saved_ = *saved;
    phase_ = Phase::idle;  // also after a failure: a session on a full disk is not kept for another try
    recorder_.reset();
    result_.clear();
  });
  return said(202, "saving");
}

PageAnswer OperatorDesk::measure_again(const std::string& id) {
  if (const auto folder = sessions::folder_of(settings_.root, id); !folder) return failed(folder.error());
  {
    const std::lock_guard lock(mutex_);
    if (job_.running) return said(409, "another task is running; wait until it has ended");
    if (phase_ == Phase::recording) return said(409, "a person is being recorded; measure again after that");
  }
  start_job("measure", id, [this, id](Job& job) {
    auto done = settings_.measure(id);
    if (done)
      job.result = std::move(*done);
    else
      job.error = done.error().message;
  });
  return said(202, "measuring");
}

void OperatorDesk::start_job(const std::string& kind, const std::string& id, std::function<void(Job&)> work) {
  if (job_thread_.joinable()) job_thread_.join();  // its work is done: `running` was false
  {
    const std::lock_guard lock(mutex_);
    job_ = {kind, id, "", nullptr, true};
  }
  auto run = [this, kind, id, work = std::move(work)] {
    Job job{kind, id, "", nullptr, false};
    try {
      work(job);
    } catch (const std::exception& error) {  // it would end the program
      job.error = error.what();
    }
    const std::lock_guard lock(mutex_);
    job_ = std::move(job);
  };
  try {
    job_thread_ = std::thread(std::move(run));
  } catch (const std::exception& error) {  // no thread is left: the operator may try again
    const std::lock_guard lock(mutex_);
    job_ = {kind, id, error.what(), nullptr, false};
  }
}

PageAnswer OperatorDesk::picture(const std::string& id, const std::string& number) const {
  const auto recording = sessions::recording_of(settings_.root, id);
  if (!recording) return failed(recording.error());
  if (number.empty() || number.size() > kNumberCharactersMax ||
      number.find_first_not_of("0123456789") != std::string::npos)
    return said(400, "number is not a number");
  // In the order of their names, which are numbered with gaps.
  std::vector<std::string> names;
  std::error_code code;
  for (std::filesystem::directory_iterator it(*recording, code), end; !code && it != end; it.increment(code))
    if (it->path().extension() == ".png") names.push_back(it->path().string());
  std::sort(names.begin(), names.end());
  std::size_t index = 0;
  for (const char digit : number)
    index = std::min<std::size_t>(10 * index + static_cast<std::size_t>(digit - '0'), 1U << 20U);
  if (index >= names.size()) return said(404, "the recording has " + std::to_string(names.size()) + " frames");
  const auto bytes = read_file(names[index], kPictureBytesMax);
  if (!bytes) return failed(bytes.error());
  const auto header = hal::parse_depth_header(*bytes, names[index]);
  if (!header) return failed(header.error());
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(header->width) *
                                    static_cast<std::size_t>(header->height));
  const DepthImage depth(pixels.data(), header->width, header->height);
  if (const auto decoded = hal::decode_depth(*bytes, names[index], depth); !decoded) return failed(decoded.error());
  auto png = small_picture(depth, {});
  if (!png) return failed(png.error());
  return {200, std::make_shared<const PageFile>(PageFile{"image/png", std::move(*png)}), ""};
}

}  // namespace im2fit::apps
