// SPDX-License-Identifier: Apache-2.0
// The constants of background.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [still] came with the background (commit c186dfc); single frames are unchanged by it, no other measurement
//           on record
#pragma once

namespace im2fit::segment::background_limits {

inline constexpr int kLearnedFrames = 60;  // two seconds: longer than people stand unrecognised; [still]
inline constexpr int kEvidenceMax = 240;   // frames that something nearer must stay to become the background; [still]
inline constexpr float kKeepoutMm = 350.0F;       // beside people and before them nothing is learned; [still]
inline constexpr float kKeepoutDepthMm = 700.0F;  // of them in depth; [still]
inline constexpr int kKnownMin = 1000;            // cells, least, to decide whether the camera moved; [still]
inline constexpr float kTurnMax = 0.02F;          // of the floor's normal: 1.1 degrees; [still]
inline constexpr float kLiftMaxMm = 40.0F;        // of the camera above the floor; [still]

}  // namespace im2fit::segment::background_limits
