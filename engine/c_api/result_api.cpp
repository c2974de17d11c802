// SPDX-License-Identifier: Apache-2.0
// im2fit_result_json and im2fit_avatar: what programs write as files, into the caller's memory.
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "engine/c_api/person.h"
#if IM2FIT_HAVE_RESULT
#include "body/export/export.h"
#include "engine/report/result_json.h"
#endif

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;

// `bytes` into the caller's memory; `size` gets their number.
[[maybe_unused]] int give(im2fit_handle& h, std::span<const std::byte> bytes, std::size_t closing, void* place,
                          std::size_t capacity, std::size_t* size) {
  *size = bytes.size();
  if (capacity < bytes.size() + closing)
    return fail(&h, IM2FIT_ERROR_TOO_SMALL,
                "needs " + std::to_string(bytes.size() + closing) + " bytes, got " + std::to_string(capacity));
  std::memcpy(place, bytes.data(), bytes.size());
  std::memset(static_cast<std::byte*>(place) + bytes.size(), 0, closing);
  return IM2FIT_OK;
}

// Shared by both functions: where the answer is to go.
int check_place(im2fit_handle& h, const void* place, std::size_t capacity, std::size_t* size) {
  if (size == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the length is NULL");
  *size = 0;
  if (place == nullptr && capacity > 0)
    return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the bytes is NULL, with a capacity");
  return IM2FIT_OK;
}

#if IM2FIT_HAVE_RESULT

im2fit::Result<std::vector<std::byte>> bytes_of(im2fit::Result<std::string> text) {
  if (!text) return text.error();
  const auto bytes = std::as_bytes(std::span(*text));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

im2fit::Result<std::vector<std::byte>> avatar_bytes(const im2fit_handle& h, const im2fit::AnsweredBody& body,
                                                    int format) {
  im2fit::body::Avatar avatar;
  avatar.model = h.data.body_model.get();
  avatar.params = body.params;
  avatar.pose = body.pose;
  if (format == IM2FIT_AVATAR_GLB) return im2fit::body::glb_of(avatar);
  return bytes_of(format == IM2FIT_AVATAR_OBJ ? im2fit::body::obj_of(avatar) : im2fit::body::bvh_of(avatar));
}

#else

int without_result(im2fit_handle& h) {
  return fail(&h, IM2FIT_ERROR_UNSUPPORTED,
              "this library was built without nlohmann-json, which this function needs");
}

#endif

}  // namespace

extern "C" {

int im2fit_result_json(im2fit_handle* handle, char* text, size_t capacity, size_t* length) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (const int status = check_place(h, text, capacity, length); status != IM2FIT_OK) return status;
#if IM2FIT_HAVE_RESULT
    const auto person = im2fit::c::person_of(h);
    if (!person) return fail(&h, person.error());
    const std::string json = im2fit::result_json(**person);
    return give(h, std::as_bytes(std::span(json)), 1, text, capacity, length);
#else
    return without_result(h);
#endif
  });
}

int im2fit_avatar(im2fit_handle* handle, int32_t format, void* bytes, size_t capacity, size_t* size) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (const int status = check_place(h, bytes, capacity, size); status != IM2FIT_OK) return status;
    if (format < IM2FIT_AVATAR_GLB || format > IM2FIT_AVATAR_BVH)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "format is " + std::to_string(format) + ", expected one of IM2FIT_AVATAR_...");
#if IM2FIT_HAVE_RESULT
    if (h.data.body_model == nullptr) return im2fit::c::no_body(h);
    return im2fit::c::with_person(h, [&](const im2fit::PersonMeasurement& person) {
      const auto file = avatar_bytes(h, *person.body, format);
      if (!file) return fail(&h, file.error());
      return give(h, *file, 0, bytes, capacity, size);
    });
#else
    return without_result(h);
#endif
  });
}

}  // extern "C"
