// SPDX-License-Identifier: Apache-2.0
// im2fit_mask.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>

#include "capi/call.h"
#include "capi/mask_keeper.h"

namespace im2fit::c {

static_assert(sizeof(im2fit_mask_info) == offsetof(im2fit_mask_info, time_ns) + sizeof(std::int64_t));

void MaskKeeper::keep(const FrameSeen& frame) {
  if (!wanted_.load(std::memory_order_acquire)) return;
  const MaskView& mask = frame.mask;
  const std::lock_guard<std::mutex> lock(mutex_);
  info_ = {mask.width, mask.height, frame.result.user, 0, frame.info.sequence, frame.info.host_ns};
  const auto width = static_cast<std::size_t>(mask.width);
  for (int v = 0; v < mask.height; ++v) {
    std::uint8_t* to = pixels_.data() + static_cast<std::size_t>(v) * width;
    if (info_.user_id == 0)
      std::memset(to, 0, width);  // a figure that was refused is nobody's
    else
      std::memcpy(to, mask.row(v), width);
  }
  kept_ = true;
}

int MaskKeeper::read(std::uint8_t* mask, std::size_t capacity, im2fit_mask_info& info) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!wanted_.load(std::memory_order_relaxed)) {
    pixels_.resize(pixel_count_);
    wanted_.store(true, std::memory_order_release);
  }
  if (!kept_) return IM2FIT_ERROR_NOT_FOUND;
  info = info_;
  if (mask == nullptr) return IM2FIT_OK;
  if (capacity < pixels_.size()) return IM2FIT_ERROR_TOO_SMALL;
  std::memcpy(mask, pixels_.data(), pixels_.size());
  return IM2FIT_OK;
}

void MaskKeeper::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  kept_ = false;
}

}  // namespace im2fit::c

extern "C" int im2fit_mask(const im2fit_handle* handle, uint8_t* mask, size_t capacity, im2fit_mask_info* info,
                           size_t struct_size) {
  using im2fit::c::fail;
  // From any thread, as im2fit_poll: only the calling thread's text.
  if (handle == nullptr || (mask == nullptr && capacity > 0) || (mask == nullptr && info == nullptr))
    return fail(nullptr, IM2FIT_ERROR_INVALID_ARGUMENT,
                handle == nullptr ? "the handle is NULL" : "the place for the mask is NULL");
  if (!im2fit::c::opened_here(*handle)) return im2fit::c::fail_forked();
  try {
    im2fit_mask_info known{};
    const int status = handle->mask->read(mask, capacity, known);
    if (info != nullptr) {
      std::memcpy(info, &known, std::min(struct_size, sizeof known));
      if (struct_size > sizeof known)
        std::memset(reinterpret_cast<char*>(info) + sizeof known, 0, struct_size - sizeof known);
    }
    if (status == IM2FIT_ERROR_NOT_FOUND)
      return fail(nullptr, status, "no frame has been processed since the first call");
    if (status == IM2FIT_ERROR_TOO_SMALL)
      return fail(nullptr, status, "a mask has width x height bytes: see the info");
    return status;
  } catch (const std::bad_alloc&) {
    return fail(nullptr, IM2FIT_ERROR_NO_MEMORY, "out of memory");
  } catch (...) {
    return fail(nullptr, IM2FIT_ERROR_INTERNAL, "internal error");
  }
}
