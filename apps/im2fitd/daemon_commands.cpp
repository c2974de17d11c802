// SPDX-License-Identifier: Apache-2.0
// What clients ask the service for: docs/daemon.md. All of it between two frames.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/common/facts_form.h"
#include "apps/im2fitd/daemon.h"
#include "apps/im2fitd/log.h"
#include "body/export/export.h"
#include "core/file.h"
#include "hal/frame_path.h"

namespace im2fit::daemon {
namespace {

using apps::Json;

Json with_id(Json event, const Json& id) {
  if (!id.is_null()) event["id"] = id;
  return event;
}

Result<std::vector<std::byte>> avatar_bytes(const body::Avatar& avatar, const std::string& format) {
  if (format == "glb") return body::glb_of(avatar);
  const auto text = format == "obj" ? body::obj_of(avatar) : body::bvh_of(avatar);
  if (!text) return text.error();
  const auto bytes = std::as_bytes(std::span(*text));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace

// `source`: null while no camera is there. A person who is measured already is reported once, with the latest facts.
Status Daemon::serve_clients(const hal::Source* source) {
  publisher_->serve(greeting());
  bool corrected = false;
  for (const ClientLine& line : publisher_->take_lines())
    if (handle_line(line, source)) corrected = true;
  if (!corrected) return Ok{};
  const EngineResult result = engine_->result();
  return reported_ && !erased_ && result.measured && result.session == session_ ? say_person(result, *source)
                                                                                : Status(Ok{});
}

void Daemon::refuse(std::uint64_t client, const std::string& reason, const Json& id) {
  publisher_->answer(client, apps::line_of(with_id({{"event", "refused"}, {"reason", reason}}, id)));
}

// True: a fact of a person who is measured already.
bool Daemon::handle_line(const ClientLine& line, const hal::Source* source) {
  Json id;
  if (line.too_long) {
    refuse(line.client, fmt::format("a line has more than {} bytes", kClientLineMax), id);
    return false;
  }
  const auto command = parse_command(line.text, id);
  if (!command) {
    refuse(line.client, command.error().message, id);
    return false;
  }
  // What was measured can be deleted without a camera.
  bool corrected = false;
  const bool needs_camera = command->wish != Wish::erase && command->wish != Wish::avatar;
  const auto fault = needs_camera && (source == nullptr || engine_ == nullptr) ? std::optional<std::string>(kNoCamera)
                                                                               : obey(line, *command, corrected);
  if (fault) refuse(line.client, *fault, id);
  return corrected;
}

std::optional<std::string> Daemon::obey(const ClientLine& line, const Command& command, bool& corrected) {
  static constexpr char kNotConsented[] = "nobody has consented: nobody is looked at";
  switch (command.wish) {
    case Wish::consent:
      return take_consent(command);
    case Wish::erase:
      return erase(command);
    case Wish::avatar:
      return send_avatar(line, command);
    case Wish::known:
      return consented_ ? take_facts(command, corrected) : kNotConsented;
    case Wish::select_user:
      return consented_ ? select_user(command) : kNotConsented;
    case Wish::reset:
      if (!consented_) return kNotConsented;
      begin_anew();
      say(with_id({{"event", "reset"}, {"frame", frames_}}, command.client));
      return std::nullopt;
    case Wish::users:
      if (!consented_) return kNotConsented;
      send_users(line, command);
      return std::nullopt;
    case Wish::mask: {
      if (!consented_) return kNotConsented;
      const std::lock_guard lock(masks_.mutex);
      masks_.wanted = true;
      masks_.clients.emplace_back(line.client, command.client);
      return std::nullopt;
    }
  }
  return std::nullopt;
}

// What the person of the present session reports. The log has no value of it.
std::optional<std::string> Daemon::take_facts(const Command& command, bool& corrected) {
  const auto facts = apps::facts_of_form(command.value.dump());
  if (!facts) return "known: " + facts.error().message;
  // The engine may have gone on to the next person since the last frame that was handled.
  const std::uint32_t session = engine_->result().session;
  const bool measured = reported_ && session == session_;
  if (measured && erased_) return "known: the measurement of this person was deleted";
  if (auto set = engine_->set_known(*facts, session); !set) return "known: " + set.error().message;
  if (!measured) facts_ = *facts;
  say(with_id({{"event", "known"}, {"frame", frames_}, {"person", measured ? persons_ : persons_ + 1}},
              command.client));
  corrected = measured;
  return std::nullopt;
}

std::optional<std::string> Daemon::take_consent(const Command& command) {
  if (!config_.consent_ask) return "consent: this service measures whoever comes (consent.ask in its configuration)";
  if (consented_) return "consent: somebody has consented already";
  begin_anew();
  body_.reset();  // of the person before
  consented_ = true;
  say(with_id({{"event", "visit"}, {"state", "MEASURING"}}, command.client));
  return std::nullopt;
}

std::optional<std::string> Daemon::select_user(const Command& command) {
  if (reported_) return "select_user: a person is measured; reset begins anew";
  const int user = command.value.get<int>();
  engine_->select_user(user);
  say(with_id({{"event", "selected"}, {"frame", frames_}, {"user", user}}, command.client));
  return std::nullopt;
}

// Nothing of the frames so far is kept: the scene, too, is found again.
void Daemon::begin_anew() {
  engine_->reset();
  engine_->select_user(0);
  session_ = engine_->result().session;
  frame_ns_ = in_view_ns_ = -1;
  reported_ = erased_ = false;
  facts_.reset();
  shown_.reset();
  state_event_ = nullptr;
}

// The last result's file, and what a program that was killed has left of writing it. What is still there, or "".
std::string Daemon::erase_kept() {
  if (state_directory_.empty()) return "";
  const std::string kept = "last-result.json";
  std::vector<std::filesystem::path> found;
  std::error_code code;
  std::filesystem::directory_iterator it(state_directory_, code);
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code))
    if (const std::string name = it->path().filename().string(); name == kept || is_temporary_of(name, kept))
      found.push_back(it->path());
  for (const auto& path : found)
    if (!code) std::filesystem::remove(path, code);
  if (!code) return "";
  return "delete: " + state_directory_ + "/" + kept + " was not deleted: " + code.message() +
         "; make the folder writable and send delete again";
}

// Without consent.ask the engine keeps the numbers of a person in view until that person has left: it would measure
// them again otherwise.
std::optional<std::string> Daemon::erase(const Command& command) {
  body_.reset();
  const std::string fault = erase_kept();
  facts_.reset();
  if (engine_ != nullptr && consented_) {
    if (config_.consent_ask)
      end_consent();
    else if (reported_)
      erased_ = true;
    else
      begin_anew();
  }
  if (!fault.empty()) {
    log(Level::error, fault);
    return fault;
  }
  say(with_id({{"event", "deleted"}, {"frame", frames_}, {"person", persons_}}, command.client));
  log(Level::info, "a client had the last measurement deleted");
  return std::nullopt;
}

std::optional<std::string> Daemon::send_avatar(const ClientLine& line, const Command& command) {
  if (!body_) return "avatar: nobody is measured, or the models have no body";
  if (publisher_->owes(line.client)) return "avatar: read the earlier answer first";
  body::Avatar avatar;
  avatar.model = data_.body_model.get();
  avatar.params = body_->params;
  avatar.pose = body_->pose;
  const auto format = command.value.get<std::string>();
  const auto bytes = avatar_bytes(avatar, format);
  if (!bytes) return "avatar: " + bytes.error().message;
  publisher_->answer_long(line.client, apps::line_of(with_id({{"event", "avatar"},
                                                              {"person", persons_},
                                                              {"format", format},
                                                              {"bytes", bytes->size()},
                                                              {"base64", base64_of(*bytes)}},
                                                             command.client)));
  return std::nullopt;
}

void Daemon::send_users(const ClientLine& line, const Command& command) {
  const EngineResult result = engine_->result();
  const auto left_out = left_out_of(result);
  Json users = Json::array();
  for (int i = 0; i < result.user_count; ++i) {
    const User& user = result.users[static_cast<std::size_t>(i)];
    if (!user.confirmed) continue;
    Json one = {{"user", user.id},
                {"distance_mm", std::lround(user.centroid_mm.z)},
                {"box", {user.u_min, user.v_min, user.u_max, user.v_max}},
                {"measured", user.id == result.user}};
    for (const LeftOutUser& other : left_out)
      if (other.user == user.id) one["left_out"] = other.reason;
    users.push_back(std::move(one));
  }
  publisher_->answer(line.client, apps::line_of(with_id({{"event", "users"}, {"frame", frames_}, {"users", users}},
                                                        command.client)));
}

// After a frame: those who wait for a mask get it.
void Daemon::send_masks() {
  const std::lock_guard lock(masks_.mutex);
  if (!masks_.taken) return;
  masks_.taken = false;
  const auto png = mask_png({masks_.pixels.data(), masks_.width, masks_.height});
  for (const auto& [client, id] : std::exchange(masks_.clients, {})) {
    if (!png || publisher_->owes(client)) {
      refuse(client, png ? "mask: read the earlier answer first" : "mask: " + png.error().message, id);
      continue;
    }
    publisher_->answer_long(client, apps::line_of(with_id({{"event", "mask"},
                                                           {"sequence", masks_.sequence},
                                                           {"user", masks_.user},
                                                           {"width", masks_.width},
                                                           {"height", masks_.height},
                                                           {"png", base64_of(std::as_bytes(std::span(*png)))}},
                                                          id)));
  }
  masks_.pixels.clear();
}

// The frames that follow are not looked at.
void Daemon::end_consent() {
  consented_ = false;
  begin_anew();
  const std::lock_guard lock(masks_.mutex);
  masks_.wanted = masks_.taken = false;
  masks_.pixels.clear();
  for (const auto& [client, id] : std::exchange(masks_.clients, {})) refuse(client, "mask: the visit is over", id);
  say({{"event", "visit"}, {"state", "ASKING"}});
}

// Consent without a person in view ends: the next one has not consented.
void Daemon::watch_consent() {
  if (!config_.consent_ask || reported_ || in_view_ns_ < 0) return;
  if (frame_ns_ - in_view_ns_ > std::int64_t{config_.consent_absent_s} * 1'000'000'000) end_consent();
}

}  // namespace im2fit::daemon
