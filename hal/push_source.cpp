// SPDX-License-Identifier: Apache-2.0
#include "hal/push_source.h"

#include <chrono>
#include <cstring>
#include <string>

namespace im2fit::hal {

Result<std::unique_ptr<PushSource>> PushSource::create(const Intrinsics& camera, const Options& options) {
  if (auto ok = check_intrinsics(camera, "pushed frames"); !ok) return ok.error();
  if (!is_rotation(options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  if (options.ring_frames < 1 || options.ring_frames > 64)
    return Error{ErrorCode::invalid_argument,
                 "ring_frames is " + std::to_string(options.ring_frames) + ", expected 1 to 64"};
  return std::unique_ptr<PushSource>(new PushSource(camera, options));
}

PushSource::PushSource(const Intrinsics& camera, const Options& options)
    : path_(camera, options.rotate_deg), ring_(static_cast<std::size_t>(options.ring_frames)) {
  for (auto& slot : ring_) slot.pixels.resize(path_.pixel_count());
  info_.uri = "push";
  info_.name = "pushed frames";
  info_.intrinsics = path_.upright();
  info_.intrinsics_origin = IntrinsicsOrigin::caller;
  info_.rotate_deg = options.rotate_deg;
  info_.live = options.live;
}

Status PushSource::push(DepthView frame, std::int64_t host_ns, std::int64_t device_us) {
  std::unique_lock lock(mutex_);
  return push_locked(lock, frame, {next_sequence_, host_ns, device_us});
}

Status PushSource::push(DepthView frame, const FrameInfo& info) {
  std::unique_lock lock(mutex_);
  return push_locked(lock, frame, info);
}

Status PushSource::push_locked(std::unique_lock<std::mutex>& lock, DepthView frame, const FrameInfo& info) {
  if (frame.pixels == nullptr || frame.width != path_.camera().width || frame.height != path_.camera().height)
    return Error{ErrorCode::invalid_argument, "pushed frame is " + std::to_string(frame.width) + "x" +
                                                  std::to_string(frame.height) + ", expected " +
                                                  std::to_string(path_.camera().width) + "x" +
                                                  std::to_string(path_.camera().height) + " as the intrinsics say"};
  if (info_.live && count_ == ring_.size()) {
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
  changed_.wait(lock, [&] { return finished_ || count_ < ring_.size(); });
  if (finished_) return Error{ErrorCode::end_of_stream, "the stream is finished; no more frames are taken"};
  Slot& slot = ring_[(first_ + count_) % ring_.size()];
  const auto width = static_cast<std::size_t>(frame.width);
  for (int v = 0; v < frame.height; ++v)
    std::memcpy(slot.pixels.data() + static_cast<std::size_t>(v) * width, frame.row(v),
                width * sizeof(std::uint16_t));
  slot.info = info;
  next_sequence_ = info.sequence + 1;
  ++count_;
  changed_.notify_all();
  return Ok{};
}

void PushSource::finish() {
  const std::lock_guard lock(mutex_);
  finished_ = true;
  changed_.notify_all();
}

Status PushSource::start() {
  return Ok{};
}

Result<FrameInfo> PushSource::next(DepthImage depth, int timeout_ms) {
  if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
  std::unique_lock lock(mutex_);
  const auto ready = [&] { return count_ > 0 || finished_; };
  if (!changed_.wait_for(lock, std::chrono::milliseconds(timeout_ms), ready))
    return Error{ErrorCode::timeout, "no frame was pushed within " + std::to_string(timeout_ms) + " ms"};
  if (count_ == 0) return Error{ErrorCode::end_of_stream, "no more frames: the caller finished the stream"};
  const Slot& slot = ring_[first_];
  path_.deliver(DepthView(slot.pixels.data(), path_.camera().width, path_.camera().height), depth);
  const FrameInfo info = slot.info;
  first_ = (first_ + 1) % ring_.size();
  --count_;
  book_.saw(info.sequence);
  changed_.notify_all();
  return info;
}

void PushSource::stop() {
  finish();
}

SourceStats PushSource::stats() const {
  const std::lock_guard lock(mutex_);
  return book_.stats();
}

}  // namespace im2fit::hal
