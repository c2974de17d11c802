// SPDX-License-Identifier: Apache-2.0
#include "person/person_measurement.h"

namespace im2fit {

Result<PersonMeasurement> measurement_of(const Engine& engine, const MeasurementParts& parts,
                                         const hal::SourceInfo& source) {
  if (auto sound = engine.fault(); !sound) return sound.error();
  return measurement_of(engine.result(), parts, source);
}

Result<PersonMeasurement> measurement_of(const EngineResult& result, const MeasurementParts& parts,
                                         const hal::SourceInfo& source) {
  PersonMeasurement person;
  person.result = result;
  person.source = source;
  person.site = parts.site;
  if (!person.result.measured) return person;
  const index::Answer& answer = person.result.answer;
  if (parts.sizes != nullptr)
    person.size = size_probabilities(*parts.sizes, answer.measurements[measurement_index(Measurement::chest_girth)],
                                     answer.female);
  if (parts.body_model == nullptr || parts.index == nullptr) return person;
  body::MeasurementFitter fitter(*parts.body_model);
  auto body = body_of_answer(fitter, answer, person.result.measured_joints, person.result.floor, person.result.seen);
  if (!body) return body.error();
  person.body = std::move(*body);
  person.modifier_names = parts.body_model->modifier_names();
  if (parts.tape == nullptr) return person;
  person.tape = parts.tape;
  person.tape_values.resize(parts.tape->definitions.size());
  body::TapeMeasurer(*parts.body_model).measure(*parts.tape, fitter.measured(), person.tape_values);
  person.tape_intervals = tape_intervals(*parts.tape, person.tape_values, answer);
  return person;
}

}  // namespace im2fit
