// SPDX-License-Identifier: Apache-2.0
#include "capi/copy_out.h"

#include <cstring>
#include <string>

namespace im2fit::c {

int check_place(im2fit_handle& handle, const void* place, std::size_t capacity, std::size_t* size) {
  if (size == nullptr) return fail(&handle, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the length is NULL");
  *size = 0;
  if (place == nullptr && capacity > 0)
    return fail(&handle, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the bytes is NULL, with a capacity");
  return IM2FIT_OK;
}

int copy_out(im2fit_handle& handle, std::span<const std::byte> bytes, std::size_t closing, void* place,
             std::size_t capacity, std::size_t* size) {
  *size = bytes.size();
  if (capacity < bytes.size() + closing)
    return fail(&handle, IM2FIT_ERROR_TOO_SMALL,
                "needs " + std::to_string(bytes.size() + closing) + " bytes, got " + std::to_string(capacity));
  std::memcpy(place, bytes.data(), bytes.size());
  std::memset(static_cast<std::byte*>(place) + bytes.size(), 0, closing);
  return IM2FIT_OK;
}

int without_result(im2fit_handle& handle) {
  return fail(&handle, IM2FIT_ERROR_UNSUPPORTED,
              "this library was built without nlohmann-json, which this function needs");
}

}  // namespace im2fit::c
