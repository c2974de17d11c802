// SPDX-License-Identifier: Apache-2.0
// What happens before a camera, as JSON objects of one line each: `live --json` prints them, im2fitd publishes them.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/reconnecting_source.h"
#include "report/result_json.h"

namespace im2fit::apps {

using Json = nlohmann::ordered_json;

// {"event": "state", ...} holds the contents of a display. A new event is sent only when one of these five fields of
// a result changes.
struct ShownState {
  SessionState state = SessionState::searching;
  GuidanceSet guidance = 0;
  ArmSet arms_close = 0;
  int user = 0;
  std::uint32_t left_out = 0;  // bits of the ids of those left out
  bool operator==(const ShownState&) const = default;
};
ShownState shown_state(const EngineResult& result);
Json state_event(std::uint64_t frame, const EngineResult& result);
Json left_event(std::uint64_t frame, int person);
// "result" holds what result.json does.
Json measured_event(std::uint64_t frame, int person, const std::string& result);
// The camera went away, was taken for another, came back, was given up.
Json camera_event(const hal::ReconnectStats& stats, const hal::SourceInfo& source);
// The same in words for a log.
std::string camera_words(const hal::ReconnectStats& stats, const hal::SourceInfo& source);
std::string name_of(hal::Presence presence);  // "PRESENT", "LOST", "GIVEN_UP"

// On one line, with its line end; text that is no UTF-8 has its odd bytes replaced.
std::string line_of(const Json& event);

}  // namespace im2fit::apps
