// SPDX-License-Identifier: Apache-2.0
#include "capi/call.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

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

}  // namespace im2fit::c
