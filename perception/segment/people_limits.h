// SPDX-License-Identifier: Apache-2.0
// The constants of people.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [empty] came with fewer false users: of 10,000 empty frames 226 before, 54 after, all changes together
//           (commit 3db21d5)
//   [round] came with round trunks and legs: of 1,000 empty frames 436 showed a user before, 3 after; all
//           changes together (commit 1e3516a)
//   [odds]  came with the shape's log-odds, for bent people in gowns (commit a94b161;
//           docs/tracker-evaluation.md)
//   [rooms] chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::people_limits {

// Poles, and what floats.
inline constexpr float kShinLowMm = 200.0F;    // above the floor: shins are seen from here; [rooms]
inline constexpr float kThighMm = 900.0F;      // to here, thighs; [rooms]
inline constexpr float kHangsFarMm = 3300.0F;  // beyond, disparity steps make coats round: legs must be seen; [empty]
inline constexpr float kPoleMm = 50.0F;        // width of a pole, most; calves one behind the other have 65; [empty]
inline constexpr float kPoleCells = 1.2F;      // and so many cells, for its edges; [empty]
inline constexpr float kPoleMaxMm = 80.0F;     // but never more; [empty]
inline constexpr int kPoleRows = 3;            // so many rows in succession; [empty]
inline constexpr float kLowMaxMm = 250.0F;     // above the floor: what ends lower stands; [rooms]

// A surface with a head.
inline constexpr float kHeadedAreaMinM2 = 0.06F;   // area, least; [rooms]
inline constexpr float kHeadedTallMinMm = 300.0F;  // height, least; [rooms]
inline constexpr float kHeadRoundMin =
    6.0F;  // roundness of the whole, or of the upper half where furniture hangs on it (commit 5651a96)

// A surface without one, by its roundness.
inline constexpr float kShapeRoundMin =
    14.0F;  // roundness above legs; of 274 people without a head 99 % are above (commit 5651a96)
inline constexpr float kCutRoundMin =
    8.0F;  // of trunks cut off above; coats against the border are below 6 (commit 5651a96)
inline constexpr float kShapeFarMm = 4000.0F;      // beyond, a disparity step is as deep as a leg is round; [round]
inline constexpr float kTrunkBulgeMinMm = 5.0F;    // of the trunk above legs, least; [round]
inline constexpr float kTrunkBulgeMaxMm = 110.0F;  // and most; [round]
inline constexpr float kTrunkMisfitMax = 0.5F;     // of a trunk cut off above and below; [round]
inline constexpr float kCandidateOddsMin =
    -5.0F;  // log-odds of a candidate, least; bent people in gowns have -3; [odds]

// A surface without one, by its size.
inline constexpr float kReliefMinMm = 14.0F;       // from its best plane, least; [rooms]
inline constexpr float kReliefQuanta = 0.5F;       // and so many disparity steps; [rooms]
inline constexpr float kReliefMaxMm = 220.0F;      // most; [rooms]
inline constexpr float kWideMinMm = 250.0F;        // width, least; [rooms]
inline constexpr float kCutTallMinMm = 600.0F;     // cut off above: height, least; [rooms]
inline constexpr float kCutWideMaxMm = 1500.0F;    // width, most; [rooms]
inline constexpr float kCutAreaMinM2 = 0.18F;      // area, least; [rooms]
inline constexpr float kCutAreaMaxM2 = 1.6F;       // and most; [rooms]
inline constexpr float kCutFillMin = 0.25F;        // of its box, least; [rooms]
inline constexpr float kCutFillMax = 0.86F;        // and most; [rooms]
inline constexpr float kWholeTallMinMm = 1250.0F;  // whole: height, least; [rooms]
inline constexpr float kWholeTallMaxMm = 2500.0F;  // and most; [rooms]
inline constexpr float kWholeWideMaxMm = 1700.0F;  // width, most: arms held out; [rooms]
inline constexpr float kWholeAreaMinM2 = 0.22F;    // area, least; [rooms]
inline constexpr float kWholeAreaMaxM2 = 1.3F;     // and most; [rooms]
inline constexpr float kWholeFillMin = 0.18F;      // of its box, least; [rooms]
inline constexpr float kWholeFillMax = 0.72F;      // and most; [rooms]

}  // namespace im2fit::segment::people_limits
