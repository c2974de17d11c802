// SPDX-License-Identifier: Apache-2.0
// What is remembered of a person's arms, so that no few lucky frames are measured. This is the one place of the rule:
//
//   1. A frame says `close` when it carries ARMS_CLOSE, `apart` when it carries no code at all, else nothing.
//   2. An arm is held to be close once 4 of the last 8 frames that say something name it, until 1 is left. While an
//      arm is held, frames carry ARMS_CLOSE and are not accumulated, whatever they show.
//   3. A capture (the frames from the first accumulated one on) more than half of whose frames carry ARMS_CLOSE is
//      forgotten instead of measured. When the stream ends before all frames wanted are accumulated, the frames of
//      the whole session count in place of the capture's.
//
// Plain data, counted in frames: part of the session (session.h).
#pragma once

#include <array>
#include <cstdint>

#include "core/guidance.h"

namespace im2fit {

struct ArmsMemory {
  std::array<std::uint32_t, kArmCount> history{};  // bit 0: the last frame that said something; 1: that arm was close
  ArmSet held = 0;
  struct Share {
    int said = 0, close = 0;  // frames
  };
  Share session, capture;
};

// One frame: `guidance` of the detection, `close` the arms its ARMS_CLOSE is about. `accumulated`: frames before this
// one; 0 begins the capture. Returns the arms that are close in this frame, held ones included.
ArmSet remember_arms(ArmsMemory& memory, GuidanceSet guidance, ArmSet close, int accumulated);
// Whether so many frames were close that what is accumulated must not be measured.
bool mostly_close(const ArmsMemory::Share& share);

}  // namespace im2fit
