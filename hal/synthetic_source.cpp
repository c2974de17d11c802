// SPDX-License-Identifier: Apache-2.0
#include "hal/synthetic_source.h"

#include <chrono>
#include <string>
#include <thread>
#include <utility>

namespace im2fit::hal {
namespace {

std::int64_t due_ns(std::uint64_t index) {
  return static_cast<std::int64_t>(index) * 1'000'000'000 / SyntheticSource::kFps;
}

}  // namespace

Result<std::unique_ptr<SyntheticSource>> SyntheticSource::create(const Intrinsics& camera, SourceInfo info,
                                                                 Generator generator, Poser poser) {
  if (auto ok = check_intrinsics(camera, info.name.empty() ? "synthetic camera" : info.name); !ok) return ok.error();
  if (!is_rotation(info.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(info.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  if (!generator) return Error{ErrorCode::invalid_argument, "a synthetic source needs a function that makes frames"};
  return std::unique_ptr<SyntheticSource>(
      new SyntheticSource(camera, std::move(info), std::move(generator), std::move(poser)));
}

SyntheticSource::SyntheticSource(const Intrinsics& camera, SourceInfo info, Generator generator, Poser poser)
    : info_(std::move(info)),
      path_(camera, info_.rotate_deg),
      generator_(std::move(generator)),
      poser_(std::move(poser)) {
  if (info_.uri.empty()) info_.uri = "synthetic";
  if (info_.name.empty()) info_.name = "synthetic camera";
  info_.intrinsics = path_.upright();
  info_.intrinsics_origin = IntrinsicsOrigin::synthetic;
}

Status SyntheticSource::start() {
  index_ = 0;
  started_ns_ = monotonic_ns();
  book_.reset();
  return Ok{};
}

Result<FrameInfo> SyntheticSource::next(DepthImage depth, int timeout_ms) {
  if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
  if (info_.live) {
    const std::int64_t elapsed_ns = monotonic_ns() - started_ns_;
    while (due_ns(index_ + 1) <= elapsed_ns) ++index_;
    const std::int64_t wait_ns = due_ns(index_) - elapsed_ns;
    const std::int64_t allowed_ns = std::int64_t{1'000'000} * timeout_ms;
    std::this_thread::sleep_for(std::chrono::nanoseconds(wait_ns < allowed_ns ? wait_ns : allowed_ns));
    if (wait_ns > allowed_ns)
      return Error{ErrorCode::timeout, info_.name + ": no frame within " + std::to_string(timeout_ms) + " ms"};
  }
  if (info_.frame_count >= 0 && index_ >= static_cast<std::uint64_t>(info_.frame_count))
    return Error{ErrorCode::end_of_stream, info_.name + ": all frames were delivered"};
  if (!generator_(index_, path_.camera_image()))
    return Error{ErrorCode::end_of_stream, info_.name + ": all frames were delivered"};
  path_.deliver(depth);
  FrameInfo frame;
  frame.sequence = index_;
  frame.host_ns = info_.live ? monotonic_ns() : due_ns(index_);
  frame.device_us = due_ns(index_) / 1000;
  if (poser_)
    if (const auto pose = poser_(index_)) frame.pose = rotate_upright(*pose, info_.rotate_deg);
  book_.saw(index_);
  ++index_;
  return frame;
}

}  // namespace im2fit::hal
