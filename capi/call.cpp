// SPDX-License-Identifier: Apache-2.0
#include "capi/call.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

namespace im2fit::c {
namespace {

using ErrorText = std::array<char, 512>;
thread_local ErrorText thread_error{};

void keep(ErrorText& place, std::string_view text) {
  const std::size_t length = std::min(text.size(), place.size() - 1);
  std::memcpy(place.data(), text.data(), length);
  place[length] = '\0';
}

}  // namespace

int fail(im2fit_handle* handle, int status, std::string_view text) {
  keep(thread_error, text);
  if (handle == nullptr) return status;
  keep(handle->error, text);
  if (handle->log != nullptr) handle->log(handle->log_user, status, handle->error.data());
  return status;
}
int fail(im2fit_handle* handle, const Error& error) {
  return fail(handle, status_of(error.code), error.message);
}

const char* last_error_of_thread() {
  return thread_error.data();
}

bool opened_here(const im2fit_handle& handle) {
  return handle.process == ::getpid();
}

int fail_forked() {
  return fail(nullptr, IM2FIT_ERROR_FORKED,
              "the handle was opened before fork(), in another process, and its threads are there: open one in this "
              "process");
}

int known_status(int status) {
  return status <= IM2FIT_OK && status >= IM2FIT_ERROR_FORKED ? status : static_cast<int>(IM2FIT_ERROR_IO);
}

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
