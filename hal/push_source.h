// SPDX-License-Identifier: Apache-2.0
// A source fed by the caller: a camera im2fit has no driver for, or a test.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "hal/frame_path.h"

namespace im2fit::hal {

// push() and finish() from one thread, the Source half from another. Frames wait in a ring made at creation; nothing
// allocates afterwards.
class PushSource final : public Source {
 public:
  struct Options {
    int rotate_deg = 0;
    bool live = false;    // live: a full ring drops its oldest frame; else push() waits for room
    int ring_frames = 4;  // 1..64
  };
  // `camera`: of the frames pushed, before rotation.
  static Result<std::unique_ptr<PushSource>> create(const Intrinsics& camera, const Options& options);

  // Copies the frame. `host_ns` and `device_us` as in FrameInfo; sequence counts on from the last when not given.
  // Errors: invalid_argument (size), end_of_stream (after finish() or stop()).
  Status push(DepthView frame, std::int64_t host_ns, std::int64_t device_us = -1);
  Status push(DepthView frame, const FrameInfo& info);
  void finish();

  const SourceInfo& info() const override { return info_; }
  Status start() override;
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override;
  SourceStats stats() const override;

 private:
  struct Slot {
    std::vector<std::uint16_t> pixels;
    FrameInfo info;
  };
  PushSource(const Intrinsics& camera, const Options& options);
  Status push_locked(std::unique_lock<std::mutex>& lock, DepthView frame, const FrameInfo& info);

  SourceInfo info_;
  UprightPath path_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Slot> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint64_t next_sequence_ = 0;
  bool finished_ = false;
  SequenceBook book_;
};

}  // namespace im2fit::hal
