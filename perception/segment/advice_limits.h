// SPDX-License-Identifier: Apache-2.0
// The constants of advice.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [near]  of scenes with a person nearer than a metre 9 of 20 were right before, 98 of 100 after, all changes
//           together (commit 2a687e0)
//   [codes] docs/tracker.md, Guidance: what the codes promise
//   [rooms] chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::advice_limits {

// What a code promises.
inline constexpr float kNearMm = 1000.0F;          // nearer is TOO_NEAR; [codes]
inline constexpr float kHoleShareMax = 0.30F;      // of the person's pixels without data: more is TOO_NOISY; [codes]
inline constexpr float kFeetMissingMm = 220.0F;    // lowest visible part above the floor: more is FEET_CUT; [codes]
inline constexpr float kWholeBodyMinMm = 1250.0F;  // of a body seen without a floor: less is FEET_CUT; [codes]
inline constexpr int kDeadBorderPx = 12;  // at 640 px: columns at the border that sensors leave without data; [codes]

// A person too near to be found: a trunk, or a head over shoulders.
inline constexpr int kNearShare = 8;              // of the picture, an eighth at least is near; [near]
inline constexpr float kNearHalfMm = 180.0F;      // either side of a trunk's middle; [near]
inline constexpr float kNearDepthMm = 300.0F;     // from the nearest: still the same surface; [near]
inline constexpr int kNearRowsMin = 16;           // of a trunk, least; [near]
inline constexpr float kNearBulgeMinMm = 15.0F;   // middle before the edges, least; [near]
inline constexpr float kNearBulgeMaxMm = 140.0F;  // and most; [near]
inline constexpr float kNearRoundMin = 0.6F;      // of that half way out, least; a corner 0.5, a circle 0.75; [near]
inline constexpr float kHeadWideMinMm = 90.0F;    // width, least; [near]
inline constexpr float kHeadWideMaxMm = 290.0F;   // and most; [near]
inline constexpr float kHeadTallMinMm = 50.0F;    // of a head seen, least; [near]
inline constexpr float kHeadRimMinMm = 20.0F;     // its rim behind its middle, least; [near]
inline constexpr float kShoulderReachMm = 45.0F;  // beyond the head on both sides, least; [near]

}  // namespace im2fit::segment::advice_limits
