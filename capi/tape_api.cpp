// SPDX-License-Identifier: Apache-2.0
// im2fit_tape and the names of what it measures.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "capi/person.h"
#include "person/builtin_tape.h"

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;
using im2fit::c::no_body;
using im2fit::c::with_person;

constexpr std::size_t kTapeValueSizeMin = sizeof(im2fit_tape_value);

im2fit_tape_value tape_value(const im2fit::PersonMeasurement& person, std::size_t i) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const im2fit::body::TapeDefinition& d = person.tape->definitions[i];
  if (d.kind == im2fit::body::TapeKind::refused)
    return {IM2FIT_TAPE_REFUSED, kNan, kNan, kNan, d.reason.c_str()};  // the shipped tape's: constant
  if (std::isnan(person.tape_values[i]))
    return {IM2FIT_TAPE_ABSENT, kNan, kNan, kNan, "this body has no such section"};
  const im2fit::TapeInterval& interval = person.tape_intervals[i];
  return {IM2FIT_TAPE_MEASURED, person.tape_values[i], interval.known ? interval.low : kNan,
          interval.known ? interval.high : kNan, nullptr};
}

// Places of the definitions named; or the first `count` of all.
im2fit::Result<std::vector<std::size_t>> tape_places(const char* const* ids, std::size_t count) {
  const im2fit::body::Tape& tape = im2fit::builtin_tape();
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < count; ++i) {
    if (ids != nullptr && ids[i] == nullptr)
      return im2fit::Error{im2fit::ErrorCode::invalid_argument, "id " + std::to_string(i) + " of the tape is NULL"};
    const int place = ids != nullptr ? im2fit::body::definition_index(tape, ids[i]) : static_cast<int>(i);
    if (place < 0)
      return im2fit::Error{im2fit::ErrorCode::not_found,
                           std::string("no measurement of the tape is called ") + ids[i]};
    places.push_back(static_cast<std::size_t>(place));
  }
  return places;
}

const im2fit::body::TapeDefinition* tape_definition(std::size_t index) {
  const auto& all = im2fit::builtin_tape().definitions;
  return index < all.size() ? &all[index] : nullptr;
}

}  // namespace

extern "C" {

int im2fit_tape(im2fit_handle* handle, const char* const* ids, size_t id_count, im2fit_tape_value* values,
                size_t value_size) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (values == nullptr && id_count > 0)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the values is NULL");
    if (value_size < kTapeValueSizeMin)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "value_size is not sizeof(im2fit_tape_value)");
    if (ids == nullptr && id_count > im2fit_tape_count())
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "the tape has " + std::to_string(im2fit_tape_count()) + " measurements");
    if (h.data.body_model == nullptr) return no_body(h);
    const auto places = tape_places(ids, id_count);
    if (!places) return fail(&h, places.error());
    return with_person(h, [&](const im2fit::PersonMeasurement& person) {
      char* to = reinterpret_cast<char*>(values);
      for (const std::size_t place : *places) {
        const im2fit_tape_value value = tape_value(person, place);
        std::memcpy(to, &value, sizeof value);
        std::memset(to + sizeof value, 0, value_size - sizeof value);  // fields of a newer header
        to += value_size;
      }
      return static_cast<int>(IM2FIT_OK);
    });
  });
}

size_t im2fit_tape_count(void) {
  return im2fit::builtin_tape().definitions.size();
}

const char* im2fit_tape_id(size_t index) {
  const auto* d = tape_definition(index);
  return d != nullptr ? d->id.c_str() : nullptr;
}

const char* im2fit_tape_unit(size_t index) {
  const auto* d = tape_definition(index);
  return d != nullptr ? im2fit::body::unit_of(*d).data() : nullptr;  // literals, which end in a zero byte
}

const char* im2fit_tape_iso(size_t index) {
  const auto* d = tape_definition(index);
  return d != nullptr ? d->iso_8559.c_str() : nullptr;
}

const char* im2fit_tape_name(size_t index, const char* language) {
  const auto* d = tape_definition(index);
  if (d == nullptr || language == nullptr) return nullptr;
  for (std::size_t i = 0; i < im2fit::body::kTapeLanguages.size(); ++i)
    if (im2fit::body::kTapeLanguages[i] == language) return d->names[i].c_str();
  return nullptr;
}

}  // extern "C"
