// SPDX-License-Identifier: Apache-2.0
// All that is said of a person, for the C functions.
#pragma once

#include "capi/call.h"

namespace im2fit::c {

// Of whoever is measured, made once a session; before MEASURED what the engine says now. The handle's: until the next
// call. Errors: measurement_of's.
Result<const PersonMeasurement*> person_of(im2fit_handle& handle);

int not_measured(im2fit_handle& handle);
int no_body(im2fit_handle& handle);

// Calls `use` with all that is said of whoever is measured.
template <class Use>
int with_person(im2fit_handle& handle, Use use) {
  if (!handle.engine->result().measured) return not_measured(handle);
  const auto person = person_of(handle);
  if (!person) return fail(&handle, person.error());
  return use(**person);
}

}  // namespace im2fit::c
