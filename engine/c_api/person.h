// SPDX-License-Identifier: Apache-2.0
// All that is said of a person, for the C functions.
#pragma once

#include "engine/c_handle.h"

namespace im2fit::c {

// Of whoever is measured, made once a session; before MEASURED what the engine says now. The handle's: until the next
// call. Errors: measurement_of's.
Result<const PersonMeasurement*> person_of(im2fit_handle& handle);

}  // namespace im2fit::c
