// SPDX-License-Identifier: Apache-2.0
#include "apps/common/events.h"

#include <fmt/core.h>

#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

std::string camera_name(const hal::SourceInfo& source) {
  return source.name + (source.serial.empty() ? "" : " (serial " + source.serial + ")");
}

}  // namespace

ShownState shown_state(const EngineResult& result) {
  std::uint32_t left_out = 0;
  for (const LeftOutUser& one : left_out_of(result)) left_out |= 1U << (static_cast<unsigned>(one.user) % 32U);
  return {result.state, result.guidance, result.arms_close, result.user, left_out};
}

Json state_event(std::uint64_t frame, const EngineResult& result) {
  return {{"event", "state"},
          {"frame", frame},
          {"state", std::string(im2fit::name_of(result.state))},
          {"guidance", names_of(result.guidance)},
          {"guidance_details",
           *parse_json<Json>(guidance_details_json(result, result.guidance, result.arms_close), "guidance_details")},
          {"user", result.user},
          {"view", std::string(im2fit::name_of(result.view))},
          {"frames_used", result.frames_used}};
}

Json left_event(std::uint64_t frame, int person) {
  return {{"event", "left"}, {"frame", frame}, {"person", person}};
}

Json measured_event(std::uint64_t frame, int person, const std::string& result) {
  Json event = {{"event", "measured"}, {"frame", frame}, {"person", person}};
  event["result"] = *parse_json<Json>(result, "result.json");
  return event;
}

std::string name_of(hal::Presence presence) {
  switch (presence) {
    case hal::Presence::present:
      return "PRESENT";
    case hal::Presence::lost:
      return "LOST";
    case hal::Presence::given_up:
      return "GIVEN_UP";
  }
  return "";
}

Json camera_event(const hal::ReconnectStats& stats, const hal::SourceInfo& source) {
  Json event = {{"event", "camera"},   {"state", name_of(stats.presence)},
                {"name", source.name}, {"serial", source.serial},
                {"lost", stats.lost},  {"recovered", stats.recovered}};
  if (stats.presence != hal::Presence::present) event["reason"] = stats.last_error;
  return event;
}

std::string camera_words(const hal::ReconnectStats& stats, const hal::SourceInfo& source) {
  const std::string name = camera_name(source);
  if (stats.presence == hal::Presence::present)
    return fmt::format("{} is back after {:.1f} s", name, static_cast<double>(stats.lost_ns) * 1e-9);
  if (stats.presence == hal::Presence::given_up) return fmt::format("{} did not come back", name);
  return fmt::format("{} is away, waiting for it: {}", name, stats.last_error);
}

std::string line_of(const Json& event) {
  return json_text(event) + "\n";
}

}  // namespace im2fit::apps
