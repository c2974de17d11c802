// SPDX-License-Identifier: Apache-2.0
// im2fit_push_frame and im2fit_wait.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

#include "capi/call.h"

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;

// No padding at the end: a field that comes later would be read from it.
static_assert(sizeof(im2fit_frame) == offsetof(im2fit_frame, reserved3) + sizeof(float));
constexpr std::size_t kFirstSize = offsetof(im2fit_frame, down_x);

im2fit_frame default_frame(std::size_t struct_size) {
  im2fit_frame frame{};
  frame.struct_size = struct_size;
  frame.unit_mm = 1.0F;
  frame.device_us = -1;
  return frame;
}

// A struct a newer caller made: what we do not know must be unset. The first version is the shortest.
bool copy_frame(const im2fit_frame& from, im2fit_frame& to) {
  const std::size_t size = from.struct_size;
  if (size < kFirstSize || size > 65536) return false;
  to = default_frame(sizeof to);
  std::memcpy(&to, &from, std::min(size, sizeof to));
  if (size <= sizeof to) return true;
  const std::span<const char> bytes(reinterpret_cast<const char*>(&from), size);
  return std::all_of(bytes.begin() + sizeof to, bytes.end(), [](char c) { return c == 0; });
}

}  // namespace

extern "C" {

void im2fit_frame_init(im2fit_frame* frame, size_t struct_size) {
  if (frame == nullptr) return;
  const im2fit_frame defaults = default_frame(struct_size);
  std::memset(frame, 0, struct_size);
  std::memcpy(frame, &defaults, std::min(struct_size, sizeof defaults));
}

int im2fit_push_frame(im2fit_handle* handle, const im2fit_frame* frame) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (frame == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the frame is NULL");
    im2fit_frame known;
    if (!copy_frame(*frame, known))
      return fail(&h, IM2FIT_ERROR_UNSUPPORTED,
                  "frame.struct_size fits no version of this library: call im2fit_frame_init first");
    const auto pushed = h.frames.push(*h.engine, known);
    return pushed ? static_cast<int>(IM2FIT_OK) : fail(&h, pushed.error());
  });
}

int im2fit_wait(im2fit_handle* handle, int32_t timeout_ms) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (!h.engine->wait_idle(timeout_ms)) return static_cast<int>(IM2FIT_ERROR_TIMEOUT);  // not a failure: not logged
    const auto sound = h.engine->fault();
    return sound ? static_cast<int>(IM2FIT_OK) : fail(&h, sound.error());
  });
}

}  // extern "C"
