// SPDX-License-Identifier: Apache-2.0
#include "capi/person.h"

#include <utility>

#include "person/builtin_tape.h"
#include "person/garment_fit.h"

namespace im2fit::c {

Result<const PersonMeasurement*> person_of(im2fit_handle& handle) {
  const EngineResult now = handle.engine->result();
  const bool made =
      now.measured && handle.person && handle.person->result.measured && handle.person->result.session == now.session;
  if (!made) {
    handle.forget_person();
    hal::SourceInfo source = handle.origin;
    source.intrinsics = handle.frames.session();
    MeasurementParts parts = handle.data.parts();
    parts.tape = &builtin_tape();
    auto person = measurement_of(*handle.engine, parts, source);
    if (!person) return person.error();
    if (person->body)
      person->fits = fits_of(builtin_wardrobe(), *handle.data.charts, person->result.answer.female, *person->tape,
                             person->tape_values, person->tape_intervals);
    handle.person = std::move(*person);
  }
  return &*handle.person;
}

int not_measured(im2fit_handle& handle) {
  return fail(&handle, IM2FIT_ERROR_NOT_MEASURED, "nothing is measured yet: push frames until state is MEASURED");
}

int no_body(im2fit_handle& handle) {
  return fail(&handle, IM2FIT_ERROR_UNSUPPORTED, "no body model is loaded: set settings.body_path");
}

}  // namespace im2fit::c
