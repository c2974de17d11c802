// SPDX-License-Identifier: Apache-2.0
// Times of a recording's frames, one wrong among them or not.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "core/status.h"
#include "hal/recording/recording_source.h"

namespace im2fit::hal {

// A time that is not after the one before, or more than ten seconds after it, is refused once: a flipped bit. It is
// the clock's new time when the next one follows it. After a clock that was set back, times go on from where they
// were.
class FrameTimes {
 public:
  void restart() { *this = FrameTimes(); }
  // None: this frame is refused. Times that are given are always later than those before.
  std::optional<std::int64_t> take(std::int64_t recorded_ns) {
    if (recorded_ns < 0 || recorded_ns > kRecordedTimeMaxNs) return std::nullopt;
    std::int64_t time_ns = recorded_ns + shift_ns_;
    const bool later = time_ns > last_ns_ && time_ns <= kRecordedTimeMaxNs;
    const bool follows = later && (last_ns_ < 0 || time_ns - last_ns_ <= kJumpNs);
    if (!follows && (refused_ns_ < 0 || recorded_ns <= refused_ns_)) {
      refused_ns_ = recorded_ns;
      return std::nullopt;
    }
    if (!later) {
      time_ns = last_ns_ + std::min(recorded_ns - refused_ns_, kJumpNs);
      shift_ns_ = time_ns - recorded_ns;
    }
    refused_ns_ = -1;
    last_ns_ = time_ns;
    return time_ns;
  }
  static Error refused(const std::string& frame) {
    return {ErrorCode::corrupt, frame + " has a time that is not within 10 s after the frame before; it is left out"};
  }

 private:
  static constexpr std::int64_t kJumpNs = 10'000'000'000;
  std::int64_t last_ns_ = -1, shift_ns_ = 0;
  std::int64_t refused_ns_ = -1;  // as recorded, of the frame before; -1: it was taken
};

}  // namespace im2fit::hal
