// SPDX-License-Identifier: Apache-2.0
// A camera that may be pulled out and put back: the program goes on without being started again.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hal/source.h"

namespace im2fit::hal {

// Time as the retries see it; tests bring their own.
struct RetryClock {
  std::function<std::int64_t()> now_ns;            // monotonic
  std::function<void(std::int64_t ns)> sleep_for;  // blocks the caller
};
RetryClock system_retry_clock();

enum class Presence { present, lost, given_up };

struct ReconnectStats {
  Presence presence = Presence::present;
  std::uint64_t lost = 0;       // times the camera went away
  std::uint64_t recovered = 0;  // times it came back and gave a frame
  std::uint64_t attempts = 0;   // openings tried while it was away
  std::uint64_t refused = 0;    // of those: another camera, or this one in another mode
  std::string last_error;       // why it was lost, or why the last attempt failed
  std::int64_t lost_ns = 0;     // how long the loss that ended last, or lasts, took
};

struct ReconnectOptions {
  int wait_first_ms = 100;  // from the loss to the first attempt; doubles with every attempt that fails, up to
  int wait_max_ms = 1000;
  int give_up_ms = -1;      // away for so long: next() returns no_device from then on; -1: waits for ever
  int frame_gap_ms = 3000;  // an open camera that gives nothing for so long counts as away
  int io_errors_max = 3;    // so many in a row: away
  RetryClock clock = system_retry_clock();
  // LOST, an attempt refused for another reason than the one before, returned, given up; on the thread of next().
  std::function<void(const ReconnectStats&)> changed;
};

// Wraps the source that `open` makes. When its next() returns no_device, repeats io, or delivers nothing, the source
// is closed and opened repeatedly with growing pauses. The same camera (the same serial; for cameras without one, the
// same URI) with the same intrinsics and rotation is accepted; any other is closed again and named in last_error.
// While the camera is away lost() is true, next() returns timeout after its time (later by the duration of one
// opening), and info() stays unchanged.
//
// Across a loss sequence numbers, host and device times keep growing: the first frame after it skips one sequence
// number, so that the gap is counted. It has no thread and waits by sleeping.
class ReconnectingSource final : public Source {
 public:
  // `lost`: null for the first opening, else the info of the camera that went away.
  using Opener = std::function<Result<std::unique_ptr<Source>>(const SourceInfo* lost)>;

  // Opens at once. Errors: the opener's.
  static Result<std::unique_ptr<ReconnectingSource>> open(Opener open, ReconnectOptions options);

  const SourceInfo& info() const override { return info_; }
  // A camera lost since it was opened is not an error: next() waits for it.
  Status start() override;
  // Errors besides the camera's: no_device once given up.
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override;
  SourceStats stats() const override;  // over all openings
  bool lost() const override { return about_.presence == Presence::lost; }
  std::optional<Vec3f> down() const override;
  const ReconnectStats& reconnect_stats() const { return about_; }

 private:
  ReconnectingSource(Opener open, ReconnectOptions options);
  std::optional<Result<FrameInfo>> try_next(DepthImage depth, std::int64_t left_ns);
  FrameInfo accept(const FrameInfo& frame);
  void lose(const std::string& why);
  void attempt();
  std::optional<Error> objection(const Source& candidate) const;
  Error give_up();
  void close();
  void notify() const;

  Opener open_;
  ReconnectOptions options_;
  std::unique_ptr<Source> source_;
  SourceInfo info_;
  ReconnectStats about_;
  SourceStats closed_stats_;  // of the openings that are over
  bool started_ = false;
  bool fresh_ = true;  // no frame since the camera was opened
  std::optional<FrameInfo> last_;
  std::uint64_t sequence_shift_ = 0;  // modulo 2^64
  std::int64_t host_shift_ns_ = 0;
  std::int64_t device_shift_us_ = 0;
  std::int64_t heard_ns_ = 0;  // when the open camera last gave something
  std::int64_t lost_since_ns_ = 0;
  std::int64_t attempt_ns_ = 0;  // when the next attempt is due
  int wait_ms_ = 0;
  int io_errors_ = 0;
};

}  // namespace im2fit::hal
