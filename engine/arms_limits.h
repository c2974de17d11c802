// SPDX-License-Identifier: Apache-2.0
// The constants of arms_memory.cpp: how long arms that touched the trunk are remembered. Sources:
//   [real]  330 starts of eight real people with hanging arms, each held for 45 frames, 0 to 2 px eroded: all of the
//           14,039 frames in which they are found say close; of 3,455 frames of the recordings played, arms moving,
//           3,419 do
//   [eval]  100 people of im2fit-lab eval, arms 12 to 25 degrees off the body, 30 frames each: 95 never say close,
//   four
//           in 1 to 4 frames, one, whose arm does touch, in 27
#pragma once

namespace im2fit::arms_limits {

// Frames that say something of the arms and are remembered: a quarter of a second. Longer: whoever lifts the arms
// waits longer; shorter: sleeves that flicker are believed.
inline constexpr int kWindow = 8;
// Of these, frames that say close: from so many on ARMS_CLOSE is held, ...
inline constexpr int kHeldFrom = 4;  // [real]: 8 of 8; [eval]: 2 at most where the arms are apart
// ... until so few are left.
inline constexpr int kHeldUntil = 1;
// A capture is measured when at least one of so many of its frames is free of ARMS_CLOSE.
inline constexpr int kCaptureShare = 2;

}  // namespace im2fit::arms_limits
