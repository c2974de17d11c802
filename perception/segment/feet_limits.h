// SPDX-License-Identifier: Apache-2.0
// The constants of feet.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [bits]  from rounding or the width of a word: changes the time, not the mask
//   [rooms] chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::feet_limits {

inline constexpr float kFootTopMm = 160.0F;      // above the floor: feet are grown from mask pixels below; [rooms]
inline constexpr float kFootClearMm = 18.0F;     // above the floor, least: its noise; [rooms]
inline constexpr float kFootClearQuanta = 0.6F;  // and so many disparity steps, as height; [rooms]
inline constexpr int kFootReachPx = 48;          // at 640 px: sideways and downwards from the mask; [rooms]
inline constexpr float kFootStepMm = 30.0F;      // depth from pixel to pixel, with a disparity step, most; [rooms]
inline constexpr float kMaskReachMm = 500.0F;  // of a mask pixel behind a cell of the person beside it, most; [bits]
inline constexpr float kSlackMm = 1.0F;        // far above what rounding does to a height; [bits]
inline constexpr float kToeTopMm = 70.0F;      // above the floor: below, a shoe's front is followed down; [rooms]
inline constexpr float kToeNearMm = 15.0F;  // before the front, with half a disparity step: it is the floor; [rooms]

}  // namespace im2fit::segment::feet_limits
