// SPDX-License-Identifier: Apache-2.0
// A camera that may be unplugged and plugged in again while the program runs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hal/source.h"

namespace im2fit::hal {

// The clock for retries; tests use their own.
struct RetryClock {
  std::function<std::int64_t()> now_ns;            // monotonic
  std::function<void(std::int64_t ns)> sleep_for;  // blocks the caller
};
RetryClock system_retry_clock();

enum class Presence { present, lost, given_up };

struct ReconnectStats {
  Presence presence = Presence::present;
  std::uint64_t lost = 0;       // number of losses of the camera
  std::uint64_t recovered = 0;  // number of returns with a frame
  std::uint64_t attempts = 0;   // attempts to open the camera while it was lost
  std::uint64_t refused = 0;    // attempts that found another camera or another mode
  std::string last_error;       // reason of the loss, or of the last failed attempt
  std::int64_t lost_ns = 0;     // duration of the current or last loss
};

struct ReconnectOptions {
  int wait_first_ms = 100;  // from the loss to the first attempt; doubled after each failed attempt, up to
  int wait_max_ms = 1000;
  int give_up_ms = -1;      // after this time next() returns no_device; -1: waits without limit
  int frame_gap_ms = 3000;  // a camera without a frame for this time is lost
  int io_errors_max = 3;    // consecutive errors after which the camera is lost
  RetryClock clock = system_retry_clock();
  // Called on the thread of next(): after a loss, a new reason of refusal, a return, and after giving up.
  std::function<void(const ReconnectStats&)> changed;
};

// Wraps the source that `open` makes. If its next() returns no_device, repeated io errors or no frames, the source is
// closed and opened again with increasing pauses. The same camera (by serial number, or by URI if it has none) with
// the same intrinsics and rotation is accepted. Any other camera is closed again and named in last_error. While the
// camera is lost, lost() is true, info() is unchanged, and next() returns timeout after its time (plus the duration
// of one opening).
//
// After a loss, sequence numbers, host and device times keep increasing. The first frame skips one sequence number,
// so the gap is counted. This class has no thread and waits by sleeping.
class ReconnectingSource final : public Source {
 public:
  // `lost`: null for the first opening, otherwise the info of the lost camera.
  using Opener = std::function<Result<std::unique_ptr<Source>>(const SourceInfo* lost)>;

  // Opens at once. Errors: the opener's.
  static Result<std::unique_ptr<ReconnectingSource>> open(Opener open, ReconnectOptions options);

  const SourceInfo& info() const override { return info_; }
  // If the camera was lost after opening, this is not an error: next() waits for it.
  Status start() override;
  // Errors in addition to the camera's: no_device after giving up.
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
  SourceStats closed_stats_;  // of earlier openings
  bool started_ = false;
  bool fresh_ = true;  // no frame since the camera was opened
  std::optional<FrameInfo> last_;
  std::uint64_t sequence_shift_ = 0;  // modulo 2^64
  std::int64_t host_shift_ns_ = 0;
  std::int64_t device_shift_us_ = 0;
  std::int64_t heard_ns_ = 0;  // time of the last frame
  std::int64_t lost_since_ns_ = 0;
  std::int64_t attempt_ns_ = 0;  // when the next attempt is due
  int wait_ms_ = 0;
  int io_errors_ = 0;
};

}  // namespace im2fit::hal
