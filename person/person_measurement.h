// SPDX-License-Identifier: Apache-2.0
// All reported values of one person, computed in one place: programs, the page, the daemon and the C functions read
// this and compute nothing themselves.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "body/tape.h"
#include "engine/engine.h"
#include "hal/depth_diagnosis.h"
#include "person/avatar.h"
#include "person/garment_fit.h"
#include "person/size_chart.h"
#include "person/tape_regression.h"

namespace im2fit {

// The schema of a measured person's result.json.
inline constexpr std::string_view kResultSchema = "im2fit.result/1";

struct PersonMeasurement {
  // Answer with intervals, age, clothing, joints, the paper's values, and what they rest on: views, frames, guidance.
  // Before MEASURED the state of the session alone.
  EngineResult result;
  hal::SourceInfo source;                 // of the frames
  std::uint64_t frames_damaged = 0;       // SourceStats::damaged of the source: frames left out
  hal::DepthDiagnosis diagnosis;          // of frames that show no person: why; else none
  const SiteCalibration* site = nullptr;  // what `result` was corrected by; null: nothing
  // When measured:
  std::optional<SizeAnswer> size;               // of the chest
  std::optional<AnsweredBody> body;             // with a body model
  std::span<const std::string> modifier_names;  // of body->params.modifiers
  const body::Tape* tape = nullptr;             // with `body`: the definitions measured on its mesh
  std::vector<float> tape_values;               // a value a definition; not-a-number: none
  std::vector<TapeInterval> tape_intervals;     // as tape_values; may be empty
  std::vector<GarmentFit> fits;                 // of each garment; empty: none was requested
};

// The data a measurement needs besides frames; all of it must outlive the measurement.
struct MeasurementParts {
  const index::Index* index = nullptr;          // with a body model: the engine's
  const body::BodyModel* body_model = nullptr;  // null: no body and no tape are made
  const SizeSystem* sizes = nullptr;            // null: no size is made
  const body::Tape* tape = nullptr;             // null: no tape is made
  const SiteCalibration* site = nullptr;        // whose correction the engine's settings have; null: none
};

// The engine's present result. Errors: engine.fault(), body_of_answer's. From the producer thread. Allocates; takes a
// few hundredths of a second with a body model.
Result<PersonMeasurement> measurement_of(const Engine& engine, const MeasurementParts& parts,
                                         const hal::SourceInfo& source);
// The same of a result read earlier, such as one with corrected facts (with_known). Any thread. Errors:
// body_of_answer's.
Result<PersonMeasurement> measurement_of(const EngineResult& result, const MeasurementParts& parts,
                                         const hal::SourceInfo& source);

}  // namespace im2fit
