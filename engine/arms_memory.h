// SPDX-License-Identifier: Apache-2.0
// The memory of a person's arms, so that a few lucky frames do not lead to a measurement. The rule is defined here:
//
//   1. A frame is `close` when it carries ARMS_CLOSE, `apart` when it carries no code at all, else neutral.
//   2. An arm is held as close once 4 of the last 8 frames with evidence name it, until only 1 does. While an arm is
//      held, frames carry ARMS_CLOSE and are not accumulated, whatever they show.
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
  std::array<std::uint32_t, kArmCount> history{};  // bit 0: the last frame with evidence; 1: that arm was close
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
