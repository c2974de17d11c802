// SPDX-License-Identifier: Apache-2.0
// im2fit_result_json and im2fit_avatar: what programs write as files, into the caller's memory.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capi/call.h"
#include "capi/person.h"
#if IM2FIT_HAVE_RESULT
#include "body/export/export.h"
#include "report/result_json.h"
#endif

namespace {

using im2fit::c::check_place;
using im2fit::c::fail;
using im2fit::c::guarded;

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
    return im2fit::c::copy_out(h, std::as_bytes(std::span(json)), 1, text, capacity, length);
#else
    return im2fit::c::without_result(h);
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
      return im2fit::c::copy_out(h, *file, 0, bytes, capacity, size);
    });
#else
    return im2fit::c::without_result(h);
#endif
  });
}

}  // extern "C"
