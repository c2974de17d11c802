// SPDX-License-Identifier: Apache-2.0
// The constants of split_bodies.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [joined]  came with the joining of split bodies, seed 8101: NO_PERSON instead of NOT_FRONTAL in 7 of 100
//             before, 3 after; of NOT_UPRIGHT 8 and 2; all changes together (commit a94b161)
//   [bent]    came with trunks bent far forwards, 240 full scenes of seed 8101: IoU p5 0.927 before, 0.944
//             after, all changes together (commit deeed50)
//   [astride] came with legs astride under a trunk (commit 58bc2de); no measurement of it on record
#pragma once

namespace im2fit::segment::split_bodies_limits {

inline constexpr float kLowMaxMm = 250.0F;        // lower component, above the floor: it stands; [joined]
inline constexpr float kLowerTallMinMm = 500.0F;  // its height, least; [joined]
inline constexpr float kTopMinMm = 1100.0F;       // top of both above the floor, least; [joined]
inline constexpr float kTopMaxMm = 2200.0F;       // and most; [joined]
inline constexpr float kOverMm = 200.0F;          // what the upper component reaches above the lower, least; [joined]
inline constexpr float kPartAreaMinM2 = 0.03F;    // of either, least: a head's; [joined]
inline constexpr float kPartAreaMaxM2 = 0.6F;     // and most; [joined]
inline constexpr float kLowerWideMaxMm = 700.0F;  // width of the lower, most; [bent]
inline constexpr float kAstrideMaxMm = 1000.0F;   // the same of what has the shape of legs; [astride]
inline constexpr float kUpperWideMaxMm = 1300.0F;  // width of the upper, most: arms held out; [bent]
inline constexpr float kAsideMm = 280.0F;          // between the middles sideways, most; [joined]
inline constexpr float kBehindMm = 550.0F;  // between the middles in depth, most: a trunk bent forwards; [bent]
inline constexpr float kBehindHeadMm =
    250.0F;                              // the same where a head is seen: another person's legs may be behind; [bent]
inline constexpr int kStepMaxMm = 600;   // in depth where they meet, most: a hand before the hip; [joined]
inline constexpr int kMeetRows = 4;      // between them, most: noise; [joined]
inline constexpr int kMeetCellsMin = 4;  // where they meet, least; [joined]
inline constexpr float kRoundMin = 11.0F;  // roundness of both, least; [joined]

}  // namespace im2fit::segment::split_bodies_limits
