// SPDX-License-Identifier: Apache-2.0
// The constants of arms_memory.cpp: how long arms that touched the trunk are remembered. Sources:
//   [real]  62 recordings of real people, each start held for 30 frames and played as recorded
//           (tests/real_people/arms.py): with arms on the body 0 to 1 of 10 frames show a gap
//   [eval]  people of im2fit-lab eval with arms 12 to 25 degrees off the body: none has ARMS_CLOSE in 2 of 8 frames
#pragma once

namespace im2fit::arms_limits {

// Frames that say something of the arms and are remembered: a quarter of a second. Longer: whoever lifts the arms
// waits longer; shorter: sleeves that flicker are believed.
inline constexpr int kWindow = 8;
// Of these, frames that say close: from so many on ARMS_CLOSE is held, ...
inline constexpr int kHeldFrom = 4;  // [real]: 7 or 8; [eval]: 1 at most
// ... until so few are left.
inline constexpr int kHeldUntil = 1;
// A capture is measured when at least one of so many of its frames is free of ARMS_CLOSE.
inline constexpr int kCaptureShare = 2;

}  // namespace im2fit::arms_limits
