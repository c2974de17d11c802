// SPDX-License-Identifier: Apache-2.0
// im2fit_garment_fit, im2fit_dressed_avatar and the names of garments.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "capi/call.h"
#include "capi/person.h"
#include "person/garment_fit.h"
#if IM2FIT_HAVE_RESULT && IM2FIT_HAVE_GARMENTS
#include "body/export/export.h"
#include "garment/drape/wear.h"
#include "person/dressing.h"
#endif

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;
using im2fit::c::no_body;
using im2fit::c::with_person;

static_assert(IM2FIT_FIT_TIGHT == static_cast<int>(im2fit::FitVerdict::tight));
static_assert(IM2FIT_FIT_LOOSE == static_cast<int>(im2fit::FitVerdict::loose));
static_assert(sizeof(im2fit_size_fit) ==
              offsetof(im2fit_size_fit, regions) + IM2FIT_REGION_COUNT_MAX * sizeof(im2fit_region_fit));

const im2fit::body::GarmentPattern* garment_at(std::size_t index) {
  const auto& all = im2fit::builtin_wardrobe().garments;
  return index < all.size() ? &all[index] : nullptr;
}

im2fit::Result<const im2fit::body::GarmentPattern*> garment_of(const char* id) {
  if (id == nullptr) return im2fit::Error{im2fit::ErrorCode::invalid_argument, "the garment's id is NULL"};
  const auto* pattern = im2fit::builtin_wardrobe().garment(id);
  if (pattern == nullptr)
    return im2fit::Error{im2fit::ErrorCode::not_found, std::string("no garment is called ") + id};
  return pattern;
}

im2fit::Result<const im2fit::GarmentFit*> fit_of(const im2fit::PersonMeasurement& person,
                                                 const im2fit::body::GarmentPattern& pattern) {
  for (const im2fit::GarmentFit& fit : person.fits)
    if (fit.garment == pattern.id && !fit.sizes.empty()) return &fit;
  return im2fit::Error{im2fit::ErrorCode::unsupported,
                       "the body has no such girths as " + pattern.id + " is fitted by"};
}

im2fit_size_fit to_c(const im2fit::SizeFit& fit, const im2fit::body::GarmentPattern& pattern) {
  im2fit_size_fit out{};
  fit.size.copy(out.name, sizeof out.name - 1);
  out.cost = static_cast<float>(fit.cost);
  // A test holds the shipped garments to that.
  const std::size_t count = std::min<std::size_t>(fit.regions.size(), IM2FIT_REGION_COUNT_MAX);
  out.region_count = static_cast<std::int32_t>(count);
  for (std::size_t r = 0; r < count; ++r) {
    const im2fit::RegionFit& region = fit.regions[r];
    out.regions[r] = {pattern.regions[r].id.c_str(), region.ease_mm, region.low_mm, region.high_mm,
                      static_cast<std::int32_t>(region.verdict)};
  }
  return out;
}

#if IM2FIT_HAVE_RESULT && IM2FIT_HAVE_GARMENTS

im2fit::Result<std::size_t> size_place(const im2fit::GarmentFit& fit, const char* size) {
  if (size == nullptr) return fit.best;
  std::string all;
  for (std::size_t i = 0; i < fit.sizes.size(); ++i) {
    if (fit.sizes[i].size == size) return i;
    all += (all.empty() ? "" : ", ") + fit.sizes[i].size;
  }
  return im2fit::Error{im2fit::ErrorCode::not_found,
                       std::string("no size is called ") + size + "; " + fit.chart + " has " + all};
}

// The garments to wear, innermost first, and a text that identifies the choice.
struct Chosen {
  std::vector<im2fit::Worn> worn;
  std::string words;
};
im2fit::Result<Chosen> chosen_of(const im2fit::PersonMeasurement& person, const im2fit_worn* worn,
                                 std::size_t worn_count) {
  constexpr im2fit_worn kEveryday[] = {{"trousers", nullptr}, {"t_shirt", nullptr}};
  const im2fit_worn* first = worn_count > 0 ? worn : kEveryday;
  const std::size_t count = worn_count > 0 ? worn_count : std::size(kEveryday);
  Chosen chosen;
  for (std::size_t i = 0; i < count; ++i) {
    const auto pattern = garment_of(first[i].garment);
    if (!pattern) return pattern.error();
    const auto fit = fit_of(person, **pattern);
    if (!fit) return fit.error();
    const auto place = size_place(**fit, first[i].size);
    if (!place) return place.error();
    chosen.worn.push_back({*pattern, (*fit)->sizes[*place].chest_mm});
    chosen.words += (*pattern)->id + ' ' + (*fit)->sizes[*place].size + '\n';
  }
  return chosen;
}

im2fit::Status make_dressed(im2fit_handle& h, const im2fit::PersonMeasurement& person, const Chosen& chosen) {
  const im2fit::body::BodyModel& model = *h.data.body_model;
  const im2fit::AnsweredBody& body = *person.body;
  const auto outfit = im2fit::dress(im2fit::builtin_wardrobe(), model, body.params, body.pose,
                                    person.result.answer.female > 0.5F, chosen.worn);
  if (!outfit) return outfit.error();
  im2fit::body::Avatar avatar{&model, body.params, body.pose};
  std::vector<im2fit::body::ClothLook> looks;
  for (const im2fit::Worn& one : chosen.worn) looks.push_back({one.pattern->id, one.pattern->colour});
  im2fit::body::wear(avatar, **outfit, looks);
  auto glb = im2fit::body::glb_of(avatar);
  if (!glb) return glb.error();
  h.dressed = {chosen.words, std::move(*glb)};
  return im2fit::Ok{};
}

#endif

}  // namespace

extern "C" {

int im2fit_garment_fit(im2fit_handle* handle, const char* garment, im2fit_size_fit* fits, size_t fit_size,
                       size_t capacity, size_t* count, size_t* best) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (count == nullptr || (fits == nullptr && capacity > 0))
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "count is NULL, or fits is NULL with a capacity");
    *count = 0;
    if (fit_size < sizeof(im2fit_size_fit))
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "fit_size is not sizeof(im2fit_size_fit)");
    const auto pattern = garment_of(garment);
    if (!pattern) return fail(&h, pattern.error());
    if (h.data.body_model == nullptr) return no_body(h);
    return with_person(h, [&](const im2fit::PersonMeasurement& person) {
      const auto found = fit_of(person, **pattern);
      if (!found) return fail(&h, found.error());
      const im2fit::GarmentFit& fit = **found;
      *count = fit.sizes.size();
      if (capacity < *count)
        return fail(&h, IM2FIT_ERROR_TOO_SMALL, "there are " + std::to_string(*count) + " sizes");
      char* to = reinterpret_cast<char*>(fits);
      for (const im2fit::SizeFit& size : fit.sizes) {
        const im2fit_size_fit one = to_c(size, **pattern);
        std::memcpy(to, &one, sizeof one);
        std::memset(to + sizeof one, 0, fit_size - sizeof one);  // fields of a newer header
        to += fit_size;
      }
      if (best != nullptr) *best = fit.best;
      return static_cast<int>(IM2FIT_OK);
    });
  });
}

int im2fit_dressed_avatar(im2fit_handle* handle, const im2fit_worn* worn, size_t worn_count, void* bytes,
                          size_t capacity, size_t* size) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (const int status = im2fit::c::check_place(h, bytes, capacity, size); status != IM2FIT_OK) return status;
    if (worn_count > IM2FIT_WORN_COUNT_MAX || (worn == nullptr && worn_count > 0))
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "worn is NULL with a count, or more than " + std::to_string(IM2FIT_WORN_COUNT_MAX));
#if IM2FIT_HAVE_RESULT && IM2FIT_HAVE_GARMENTS
    for (std::size_t i = 0; i < worn_count; ++i)
      if (const auto known = garment_of(worn[i].garment); !known) return fail(&h, known.error());
    if (h.data.body_model == nullptr) return no_body(h);
    return with_person(h, [&](const im2fit::PersonMeasurement& person) {
      const auto chosen = chosen_of(person, worn, worn_count);
      if (!chosen) return fail(&h, chosen.error());
      // A call that requests the size is usually followed by one that requests the bytes.
      if (h.dressed.worn != chosen->words)
        if (const auto made = make_dressed(h, person, *chosen); !made) return fail(&h, made.error());
      return im2fit::c::copy_out(h, h.dressed.glb, 0, bytes, capacity, size);
    });
#else
    return fail(&h, IM2FIT_ERROR_UNSUPPORTED,
                "this function needs nlohmann-json and garments (IM2FIT_GARMENTS), and this library was built without "
                "one of them");
#endif
  });
}

size_t im2fit_garment_count(void) {
  return im2fit::builtin_wardrobe().garments.size();
}

const char* im2fit_garment_id(size_t index) {
  const auto* pattern = garment_at(index);
  return pattern != nullptr ? pattern->id.c_str() : nullptr;
}

const char* im2fit_garment_name(size_t index, const char* language) {
  const auto* pattern = garment_at(index);
  if (pattern == nullptr || language == nullptr) return nullptr;
  for (std::size_t i = 0; i < im2fit::body::kTapeLanguages.size(); ++i)
    if (im2fit::body::kTapeLanguages[i] == language) return pattern->names[i].c_str();
  return nullptr;
}

const char* im2fit_fit_name(int verdict) {
  return verdict >= IM2FIT_FIT_TIGHT && verdict <= IM2FIT_FIT_LOOSE
             ? im2fit::name_of(static_cast<im2fit::FitVerdict>(verdict)).data()  // literals, which end in a zero byte
             : nullptr;
}

}  // extern "C"
