// SPDX-License-Identifier: Apache-2.0
// What every C function does first and last: a handle that may be used here, failures kept as text, nothing thrown
// across the border.
#pragma once

#include <cstddef>
#include <new>
#include <span>
#include <string_view>

#include "capi/c_handle.h"

namespace im2fit::c {

// Keeps `text` for im2fit_last_error, of the handle (may be null) and of the calling thread, logs it where the handle
// has a log, and returns `status`.
int fail(im2fit_handle* handle, int status, std::string_view text);
int fail(im2fit_handle* handle, const Error& error);
const char* last_error_of_thread();

// The process that opened the handle. A forked child has none of its threads: frames pushed there would wait for
// ever.
bool opened_here(const im2fit_handle& handle);
int fail_forked();

// Converts the return value of a caller's function to a status: unknown numbers become IO, with a text that names
// them.
int known_status(int status);

// Runs `body` with a usable handle, and converts any exception to a status.
template <class Body>
int guarded(im2fit_handle* handle, Body body) noexcept {
  if (handle == nullptr) return fail(nullptr, IM2FIT_ERROR_INVALID_ARGUMENT, "the handle is NULL");
  if (!opened_here(*handle)) return fail_forked();
  handle->error[0] = '\0';
  try {
    return body(*handle);
  } catch (const std::bad_alloc&) {
    return fail(handle, IM2FIT_ERROR_NO_MEMORY, "out of memory");
  } catch (...) {
    return fail(handle, IM2FIT_ERROR_INTERNAL, "internal error");
  }
}

// Bytes of a length that the caller does not know, into the caller's memory.

// Where the answer is to go; *size becomes 0.
int check_place(im2fit_handle& handle, const void* place, std::size_t capacity, std::size_t* size);
// `bytes` and `closing` zero bytes; *size gets the number of `bytes`. TOO_SMALL when `capacity` is less.
int copy_out(im2fit_handle& handle, std::span<const std::byte> bytes, std::size_t closing, void* place,
             std::size_t capacity, std::size_t* size);
// For functions that write files' bytes, in a library built without what they need.
int without_result(im2fit_handle& handle);

}  // namespace im2fit::c
