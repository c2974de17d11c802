// SPDX-License-Identifier: Apache-2.0
// The constants of person_matching.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [ids]    came with ids, or with ids that last longer: 50 clips of two people who pass, 3 switches before, 0
//            after, all changes together (commits 9873af9, f1a81d9)
//   [heads]  came with users whose heads are not seen (commit e8175d0); no measurement on record
//   [hidden] of 50 two-person clips, seed 909090: changes of id 6 before, 2 after (commit a16e488)
//   [stand]  the same clips: 2 before, 0 after (commit a94b161)
//   [odds]   came with log-odds of the shape (commit f771803): false users of 10,000 empty frames 10 before, 0
//            after
//   [rooms]  chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::person_matching_limits {

// How long.
inline constexpr float kHiddenMaxS = 5.0F;             // a confirmed user may stay hidden; [ids]
inline constexpr float kUnconfirmedHiddenMaxS = 1.0F;  // an unconfirmed one; [ids]
inline constexpr float kHeadlessHiddenMaxS = 1.5F;     // then what returns without a head may be furniture; [ids]
inline constexpr float kHeadlessMaxS = 1.0F;           // a user may lack both head and a person's size; [heads]
inline constexpr float kExpectedMaxS = 1.0F;           // a hidden head is still expected; [rooms]
inline constexpr float kCandidateHiddenMaxS = 0.3F;    // a confirmed user may be continued by a candidate; [odds]

// Association of tracks and detections.
inline constexpr float kGateMm = 350.0F;            // most: a head's jump when a raised arm is taken for it; [rooms]
inline constexpr float kGateGrowthMmPerS = 600.0F;  // more while hidden: people stop and turn; [ids]
inline constexpr float kGateMaxMm = 1400.0F;        // but no more than that; [ids]
inline constexpr float kTopGateMm = 250.0F;         // between heights of crowns: two people of unlike height; [ids]
inline constexpr float kOverHeadMm = 150.0F;  // a surface that much above the head is no crown: a coat stand; [stand]
inline constexpr float kHeadlessGateMm = 350.0F;  // of a detection without a head; [heads]
inline constexpr float kHeadlessTallMm = 300.0F;  // its height, least; [heads]
inline constexpr float kHeadlessAreaMin = 0.35F;  // of the most seen of the person, least; [heads]
inline constexpr float kHeadlessAreaMax = 1.4F;   // and most; [heads]
inline constexpr float kBesideMm = 1000.0F;       // a new candidate so near a confirmed user is part of it; [stand]
inline constexpr float kUnprovenMm = 600.0F;      // cost of a track that never had a person's shape; [hidden]
inline constexpr float kNoTopMm = 60.0F;          // cost where either has no crown; [ids]
inline constexpr float kLateMm = 100.0F;          // cost of a hidden track; [ids]

// An alpha-beta filter of places along the floor.
inline constexpr float kPlaceGain = 0.6F;          // of the place: heads are seen to a cell, 20 mm; [ids]
inline constexpr float kSpeedGain = 0.12F;         // of the speed; a new track learns faster; [ids]
inline constexpr float kSpeedMaxMmPerS = 3000.0F;  // people walk and run slower; [ids]
inline constexpr float kTopGain = 0.2F;            // of the crown's height; [ids]
inline constexpr float kAreaKeep = 0.999F;         // of the most seen area, per frame; [ids]

}  // namespace im2fit::person_matching_limits
