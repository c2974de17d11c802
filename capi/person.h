// SPDX-License-Identifier: Apache-2.0
// All reported values of a person, for the C functions.
#pragma once

#include "capi/call.h"

namespace im2fit::c {

// Of the measured person, made once a session; before MEASURED of the engine's present result. The handle owns it;
// valid until the next call. Errors: measurement_of's.
Result<const PersonMeasurement*> person_of(im2fit_handle& handle);

int not_measured(im2fit_handle& handle);
int no_body(im2fit_handle& handle);

// Calls `use` with the measured person's values.
template <class Use>
int with_person(im2fit_handle& handle, Use use) {
  if (!handle.engine->result().measured) return not_measured(handle);
  const auto person = person_of(handle);
  if (!person) return fail(&handle, person.error());
  return use(**person);
}

}  // namespace im2fit::c
