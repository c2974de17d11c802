// SPDX-License-Identifier: Apache-2.0
// What the person reports of themselves.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "capi/call.h"
#include "estimate/known_facts.h"

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;

// No padding at the end: a field that comes later would be read from it.
static_assert(sizeof(im2fit_known) == offsetof(im2fit_known, reserved) + sizeof(std::int32_t));

constexpr int bit(im2fit::KnownFact fact) {
  return static_cast<int>(im2fit::bit_of(fact));
}
static_assert(IM2FIT_KNOWN_STATURE == bit(im2fit::KnownFact::stature));
static_assert(IM2FIT_KNOWN_WEIGHT == bit(im2fit::KnownFact::weight));
static_assert(IM2FIT_KNOWN_SEX == bit(im2fit::KnownFact::sex));
static_assert(IM2FIT_KNOWN_AGE == bit(im2fit::KnownFact::age));
static_assert(IM2FIT_SEX_UNKNOWN == static_cast<int>(im2fit::KnownSex::unknown));
static_assert(IM2FIT_SEX_WOMAN == static_cast<int>(im2fit::KnownSex::woman));
static_assert(IM2FIT_SEX_MAN == static_cast<int>(im2fit::KnownSex::man));

// A struct a newer caller made: what we do not know must be unset. The first version is the shortest.
bool copy_known(const im2fit_known& from, im2fit_known& to) {
  const std::size_t size = from.struct_size;
  if (size < sizeof to || size > 65536) return false;
  std::memcpy(&to, &from, sizeof to);
  const std::span<const char> bytes(reinterpret_cast<const char*>(&from), size);
  return to.reserved == 0 && std::all_of(bytes.begin() + sizeof to, bytes.end(), [](char c) { return c == 0; });
}

im2fit::KnownValue value_of(float value, float sd, float default_sd) {
  if (value == 0 && sd == 0) return {};
  return {value, sd == 0 ? default_sd : sd};
}

}  // namespace

extern "C" {

void im2fit_known_init(im2fit_known* known, size_t struct_size) {
  if (known == nullptr) return;
  im2fit_known nothing{};
  nothing.struct_size = struct_size;
  std::memset(known, 0, struct_size);
  std::memcpy(known, &nothing, std::min(struct_size, sizeof nothing));
}

int im2fit_set_known(im2fit_handle* handle, const im2fit_known* known) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (known == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the known facts are NULL");
    im2fit_known given{};
    if (!copy_known(*known, given))
      return fail(&h, IM2FIT_ERROR_UNSUPPORTED,
                  "known.struct_size fits no version of this library: call im2fit_known_init first");
    if (given.sex < IM2FIT_SEX_UNKNOWN || given.sex > IM2FIT_SEX_MAN)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "known.sex " + std::to_string(given.sex) + ": expected IM2FIT_SEX_..., 0 to 2");
    im2fit::KnownFacts facts;
    facts.stature_mm = value_of(given.stature_mm, given.stature_sd_mm, im2fit::kStatedStatureSdMm);
    facts.weight_kg = value_of(given.weight_kg, given.weight_sd_kg, im2fit::kStatedWeightSdKg);
    facts.age_years = value_of(given.age_years, given.age_sd_years, im2fit::kStatedAgeSdYears);
    facts.sex = static_cast<im2fit::KnownSex>(given.sex);
    const im2fit::EngineResult now = h.engine->result();
    const bool of_next = now.measured && h.next_after == now.session;
    if (const auto ok = h.engine->set_known(facts, of_next ? now.session + 1 : now.session); !ok)
      return fail(&h, ok.error());
    if (!of_next) h.forget_person();
    return static_cast<int>(IM2FIT_OK);
  });
}

}  // extern "C"
