// SPDX-License-Identifier: Apache-2.0
#include "person/person_measurement.h"

namespace im2fit {

Result<PersonMeasurement> measurement_of(const Engine& engine, const MeasurementParts& parts,
                                         const hal::SourceInfo& source) {
  if (auto sound = engine.fault(); !sound) return sound.error();
  return measurement_of(engine.result(), parts, source);
}

namespace {

// The answer's own eleven, else the tape's where it has an interval.
std::optional<index::IntervalEstimate> measured_length(const PersonMeasurement& person, std::string_view id) {
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (kMeasurementTable[i].id == id) return person.result.answer.measurements[i];
  const int place = person.tape != nullptr ? definition_index(*person.tape, id) : -1;
  const auto i = static_cast<std::size_t>(place);
  if (place < 0 || i >= person.tape_intervals.size() || !person.tape_intervals[i].known ||
      !(person.tape_values[i] > 0))
    return std::nullopt;
  return index::IntervalEstimate{person.tape_values[i], person.tape_intervals[i].low, person.tape_intervals[i].high};
}

Status add_body(PersonMeasurement& person, const MeasurementParts& parts) {
  const index::Answer& answer = person.result.answer;
  body::MeasurementFitter fitter(*parts.body_model);
  auto body = body_of_answer(fitter, answer, person.result.measured_joints, person.result.floor, person.result.seen);
  if (!body) return body.error();
  person.body = std::move(*body);
  person.modifier_names = parts.body_model->modifier_names();
  if (parts.tape == nullptr) return Ok{};
  person.tape = parts.tape;
  person.tape_values.resize(parts.tape->definitions.size());
  body::TapeMeasurer(*parts.body_model).measure(*parts.tape, fitter.measured(), person.tape_values);
  person.tape_intervals = tape_intervals(*parts.tape, person.tape_values, answer);
  return Ok{};
}

}  // namespace

Result<PersonMeasurement> measurement_of(const EngineResult& result, const MeasurementParts& parts,
                                         const hal::SourceInfo& source) {
  PersonMeasurement person;
  person.result = result;
  person.source = source;
  person.site = parts.site;
  if (!person.result.measured) return person;
  if (parts.body_model != nullptr && parts.index != nullptr)
    if (auto made = add_body(person, parts); !made) return made.error();
  if (parts.sizes != nullptr)
    person.size = size_answer(
        *parts.sizes, [&](std::string_view id) { return measured_length(person, id); }, person.result.answer.female);
  return person;
}

}  // namespace im2fit
