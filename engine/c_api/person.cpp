// SPDX-License-Identifier: Apache-2.0
#include "engine/c_api/person.h"

#include <utility>

namespace im2fit::c {

Result<const PersonMeasurement*> person_of(im2fit_handle& handle) {
  const EngineResult now = handle.engine->result();
  const bool made =
      now.measured && handle.person && handle.person->result.measured && handle.person->result.session == now.session;
  if (!made) {
    handle.person.reset();
    hal::SourceInfo source = handle.origin;
    source.intrinsics = handle.frames.session();
    auto person = measurement_of(*handle.engine, handle.data.parts(), source);
    if (!person) return person.error();
    handle.person = std::move(*person);
  }
  return &*handle.person;
}

}  // namespace im2fit::c
