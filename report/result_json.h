// SPDX-License-Identifier: Apache-2.0
// result.json, schema im2fit.result/1: docs/result.md describes each field, docs/result.schema.json is
// machine-readable. The same measurement gives the same bytes on every machine.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "person/person_measurement.h"

namespace im2fit {

// "SEARCHING" and so on; "device" and so on.
std::string_view name_of(SessionState state);
std::string_view name_of(ViewSide view);      // "front", "back", "side", "unknown"
std::string_view name_of(AnswerViews views);  // "none", "front", "front+back"
std::string_view name_of(hal::IntrinsicsOrigin origin);

// Values that differ from run to run; all under "timing", which is absent without them.
struct ResultTiming {
  double total_ms = 0;
  double first_answer_ms = 0;
};

// UTF-8 with two spaces of indentation and a line end. In text that is not UTF-8 (paths may not be) the invalid bytes
// are replaced.
std::string result_json(const PersonMeasurement& person, const std::optional<ResultTiming>& timing = {});
// An entry of its `fit`, alone.
std::string fit_json(const GarmentFit& fit);

// The guidance in the file: none once measured; else the codes of the latest frame and those that at least half of
// the frames carried (the last frame alone may show an empty room).
GuidanceSet reported_guidance(const EngineResult& result);
// Which arms its ARMS_CLOSE is about: those of the latest frame, else those named in at least half of the frames with
// that code.
ArmSet reported_arms(const EngineResult& result);
// The object `guidance_details` of the codes in `codes`, as JSON: the numbers behind them. `arms`: those of
// ARMS_CLOSE.
std::string guidance_details_json(const EngineResult& result, GuidanceSet codes, ArmSet arms);
// The same, with TURN_ROUND or TURN_ON if a turn was requested and the answer rests on the front alone.
GuidanceSet reported_guidance(const PersonMeasurement& person);

}  // namespace im2fit
