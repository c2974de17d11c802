// SPDX-License-Identifier: Apache-2.0
// Bytes of a length that the caller does not know, into the caller's memory.
#pragma once

#include <cstddef>
#include <span>

#include "capi/call.h"

namespace im2fit::c {

// Where the answer is to go; *size becomes 0.
int check_place(im2fit_handle& handle, const void* place, std::size_t capacity, std::size_t* size);
// `bytes` and `closing` zero bytes; *size gets the number of `bytes`. TOO_SMALL when `capacity` is less.
int copy_out(im2fit_handle& handle, std::span<const std::byte> bytes, std::size_t closing, void* place,
             std::size_t capacity, std::size_t* size);
// For functions that write files' bytes, in a library built without what they need.
int without_result(im2fit_handle& handle);

}  // namespace im2fit::c
