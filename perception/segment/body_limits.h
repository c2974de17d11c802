// SPDX-License-Identifier: Apache-2.0
// The constants of body.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [round] came with turned and bent people: of 200 people 98.4 % found before, 99.8 % after (turned 88.2 and
//           98.5), all changes together (commit 5651a96)
//   [odds]  the range a logistic regression was fitted on, or its coefficients: 1,100 furnished rooms without
//           people, 1,180 people (commit f771803); figures: docs/tracker-evaluation.md
//   [slim]  came with people in profile: NO_PERSON instead of NOT_FRONTAL in 7 of 100 before, 3 after, all
//           changes together (commit a94b161)
//   [calm]   came with people found without a floor: of 206 calm starts of real people without a floor 28 % were
//            no one before, 0 % after (tests/real_people)
#pragma once

namespace im2fit::segment::body_limits {

// How round a surface is.
inline constexpr float kBaseMm =
    70.0F;  // either side of a point: less than a thigh is wide, more than depth noise hides; [round]
inline constexpr int kStepMaxMm = 150;            // to the points at the sides: no outline between; [round]
inline constexpr int kRunCells = 4;               // averaged along the other axis; [round]
inline constexpr int kBinZero = 128;              // bin of a bulge of 0: half of the bins
inline constexpr int kBinCount = 256;             // of 1 mm, from -kBinZero: bulges beyond count as the last
inline constexpr float kAlongWeight = 4.0F;       // median along, in units of that across; [round]
inline constexpr float kAlongUpperWeight = 0.3F;  // upper quartile along; [round]

// A body without a head to be seen.
inline constexpr float kBodyFarMm = 4000.0F;       // beyond, disparity steps are as deep as a body is round; [round]
inline constexpr float kBodyTallMinMm = 900.0F;    // height, least; [round]
inline constexpr float kBodyTopMinMm = 1000.0F;    // top above the floor, least; [round]
inline constexpr float kBodyTopMaxMm = 2200.0F;    // and most; [round]
inline constexpr float kBodyLowMaxMm = 250.0F;     // lower end above the floor, most; [round]
inline constexpr float kBodyReliefMaxMm = 180.0F;  // from its best plane, most; [round]
inline constexpr float kBodyWideMinMm = 250.0F;    // width, least; [round]
inline constexpr float kBodyAreaMinM2 = 0.28F;     // area, least; [round]
inline constexpr float kBodyAreaMaxM2 = 0.95F;     // and most; [round]
inline constexpr float kBodyFillMax = 0.7F;        // of its box, most; [round]
inline constexpr float kBodyShareMin = 0.1F;       // cells with the surface on both sides, least; [round]
inline constexpr float kBodyShareMax = 0.6F;       // and most; [round]
inline constexpr float kBodySidesMinMm = 14.0F;    // bulge of the rounder quarter, least; [round]
inline constexpr float kBodySidesMaxMm = 45.0F;    // and most; [round]
inline constexpr float kBodyRoundMin = 28.0F;      // score, least; [round]
inline constexpr float kLegsBonus = 10.0F;         // of the score, for legs; [round]

// What has log-odds at all: whole, on the floor, of a person's size.
inline constexpr float kWholeTopMinMm = 1000.0F;         // top above the floor, least; [odds]
inline constexpr float kWholeLeglessTopMinMm = 1150.0F;  // the same without legs; [odds]
inline constexpr float kCutOffTallMinMm =
    1250.0F;  // of what is cut off below and stands on no known floor, its height, least: as FEET_CUT's; [calm]
inline constexpr float kWholeWideMinMm = 240.0F;     // width, least; [odds]
inline constexpr float kWholeLowMaxMm = 420.0F;      // lower end above the floor, most; [odds]
inline constexpr float kWholeNearMm = 1100.0F;       // distance, least; [odds]
inline constexpr float kWholeAreaMinM2 = 0.15F;      // area, least; [odds]
inline constexpr float kWholeAreaMaxM2 = 1.1F;       // and most; [odds]
inline constexpr float kWholeFillMax = 0.75F;        // of its box, most; [odds]
inline constexpr float kWholeLeglessFillMin = 0.3F;  // and least, without legs; [odds]
inline constexpr float kArmsOutWideMm = 1000.0F;     // wider than that the arms are out, if it is a person; [calm]
inline constexpr float kArmsOutFillMin = 0.15F;      // of the box, least, then; a real person had 0.23; [calm]
inline constexpr float kWholeShareMin = 0.02F;       // cells with the surface on both sides, least; [odds]
inline constexpr float kSlenderWideMm =
    370.0F;  // narrower: in profile, rounder at the sides than from the front; [slim]
inline constexpr float kSlenderRoundMax = 1.5F;  // of log-odds, most that being so costs; [slim]
inline constexpr float kOddsMax = 9.0F;          // log-odds either way, most; [odds]

}  // namespace im2fit::segment::body_limits
