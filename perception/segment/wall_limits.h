// SPDX-License-Identifier: Apache-2.0
// The constants of wall.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [rooms] chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::wall_limits {

inline constexpr int kOpenCountMin = 400;      // cells not yet anything's, least, to search for a wall; [rooms]
inline constexpr int kHypothesisCount = 60;    // planes tried; [rooms]
inline constexpr int kScoredCount = 400;       // cells that vote on each; [rooms]
inline constexpr float kWidthMinMm = 1300.0F;  // along the floor, least; [rooms]
inline constexpr float kAreaMinM2 = 1.2F;      // least: more than a person with both arms out; [rooms]
inline constexpr float kOnMm = 20.0F;          // off the wall, with a disparity step: still of it; [rooms]
inline constexpr float kBehindMm = 45.0F;      // before the wall, with two disparity steps: goes with it; [rooms]
// A wall found before is looked for anew when one in so many of its votes is lost. Noise of 400 votes is 2.5 % at
// most (of a wall that has a half of them; binomial); [rooms]
inline constexpr int kFollowParts = 10;
inline constexpr float kUprightMax = 0.25F;      // sine of a wall's tilt, most; [rooms]
inline constexpr float kDistanceMinMm = 300.0F;  // of its plane from the camera, least; [rooms]

}  // namespace im2fit::segment::wall_limits
