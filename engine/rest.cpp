// SPDX-License-Identifier: Apache-2.0
#include "engine/rest.h"

#include <algorithm>

#include "perception/observe/joint_filter.h"

namespace im2fit {
namespace {

// Longer than PersonTracker and session bridge flicker (kAbsentPeriodsMax, half a second), and than a person who
// stops between two steps.
constexpr float kStillSeconds = 1.0F;
constexpr float kLookSeconds = 0.2F;  // five a second: a viewer sees that the program runs
// Changes too slow to be detected (a lamp that warms, a person who turns on the spot) are found within this time.
// Sensing a person costs five times as much as a second of comparing.
constexpr float kSenseSeconds = 5.0F;
constexpr float kHalfFrameS = 0.5F * kFramePeriodS;  // sums of frame periods fall short of a limit by rounding

}  // namespace

RestStep RestGate::step(DepthView depth, float seconds, bool nothing_to_do) {
  const bool changed = change_.changed(depth);
  if (changed) change_.keep(depth);
  still_s_ = changed ? 0 : still_s_ + seconds;
  nothing_to_do_s_ = nothing_to_do ? nothing_to_do_s_ + seconds : 0;
  sensed_s_ += seconds;
  looked_s_ += seconds;
  const bool resting = std::min(still_s_, nothing_to_do_s_) > kStillSeconds - kHalfFrameS;
  if (!resting || sensed_s_ > kSenseSeconds - kHalfFrameS) {
    sensed_s_ = looked_s_ = 0;
    return RestStep::sense;
  }
  if (looked_s_ < kLookSeconds - kHalfFrameS) return RestStep::pass;
  looked_s_ = 0;
  return RestStep::repeat;
}

void RestGate::wake() {
  change_.forget();
  still_s_ = nothing_to_do_s_ = sensed_s_ = looked_s_ = 0;
}

}  // namespace im2fit
