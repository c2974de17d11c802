// SPDX-License-Identifier: Apache-2.0
// The arrival of frames: irregular numbers and time stamps, and the time from one to the next. Use each class from
// one thread.
#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/frame_pool.h"
#include "hal/source.h"
#include "perception/observe/joint_filter.h"

namespace im2fit {

class ArrivalCounter {
 public:
  void count(const hal::FrameInfo& info, ArrivalCounts& counts) {
    if (any_) {
      if (info.sequence <= previous_.sequence)
        ++counts.sequence_repeats;
      else
        counts.sequence_gaps += info.sequence - previous_.sequence - 1;
      // Zero twice is a source without a clock.
      const bool clock = info.host_ns != 0 || previous_.host_ns != 0;
      if (clock && info.host_ns <= previous_.host_ns) ++counts.time_reversals;
    }
    any_ = true;
    previous_ = info;
  }
  void reset() { any_ = false; }

 private:
  bool any_ = false;
  hal::FrameInfo previous_;
};

// Converts seconds to periods of 1/30 s and carries the remainder. A frame counts as a fifth of a second at most, so
// that a single frame of a slow camera never counts as a long absence.
class PeriodCounter {
 public:
  int step(float seconds) {
    left_ += seconds / kFramePeriodS;
    const int periods = static_cast<int>(left_ + 0.5F);
    left_ -= static_cast<float>(periods);
    return std::min(periods, kPeriodsMax);
  }
  void reset() { left_ = 0; }

 private:
  static constexpr int kPeriodsMax = 6;
  float left_ = 0;
};

// Seconds from frame to frame by the source's clock; the nominal period where it has none or steps back.
class FrameClock {
 public:
  float step(std::int64_t host_ns) {
    const bool known = previous_ns_ != 0 && host_ns > previous_ns_;
    // Unsigned: two times may be further apart than the half that is positive.
    const std::uint64_t passed_ns = static_cast<std::uint64_t>(host_ns) - static_cast<std::uint64_t>(previous_ns_);
    previous_ns_ = host_ns;
    return known ? static_cast<float>(passed_ns) * 1e-9F : kFramePeriodS;
  }
  void reset() { previous_ns_ = 0; }

 private:
  std::int64_t previous_ns_ = 0;
};

}  // namespace im2fit
