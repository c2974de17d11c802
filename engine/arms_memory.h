// SPDX-License-Identifier: Apache-2.0
// Evidence about a person's arms over several frames, so that a few good frames do not lead to a measurement. Rules:
//
//   1. A frame is `close` if it has ARMS_CLOSE, `apart` if it has no code, otherwise neutral.
//   2. An arm is held as close when 4 of the last 8 non-neutral frames name it, until only 1 of 8 names it. While an
//      arm is held, all frames get ARMS_CLOSE and are not accumulated.
//   3. A capture starts with the first accumulated frame. If more than half of its frames have ARMS_CLOSE, it is
//      discarded. If the stream ends before frames_wanted frames are accumulated, this is decided by all frames of
//      the session instead of those of the capture.
//
// Plain data, counted in frames; part of the session (session.h).
#pragma once

#include <array>
#include <cstdint>

#include "core/guidance.h"

namespace im2fit {

struct ArmsMemory {
  std::array<std::uint32_t, kArmCount> history{};  // bit 0: the last non-neutral frame; 1: that arm was close
  ArmSet held = 0;
  struct Share {
    int said = 0, close = 0;  // frames
  };
  Share session, capture;
};

// Adds a frame. `guidance`: of the detection. `close`: the arms of its ARMS_CLOSE. `accumulated`: number of frames
// before this one; 0 begins a capture. Returns the arms that are close in this frame, including held ones.
ArmSet remember_arms(ArmsMemory& memory, GuidanceSet guidance, ArmSet close, int accumulated);
// Whether too many frames were close to measure the accumulated frames.
bool mostly_close(const ArmsMemory::Share& share);

}  // namespace im2fit
