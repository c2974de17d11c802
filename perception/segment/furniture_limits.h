// SPDX-License-Identifier: Apache-2.0
// The constants of furniture.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [cut]   came with the cut of furniture; measured together, not one by one: IoU p5 of 200 people in two
//           fresh scenes each 0.877 -> 0.927 (commit 5651a96)
//   [posts] came with the cut of chair legs; together: IoU p5 of 240 full scenes, seed 8101, 0.927 -> 0.944,
//           seated 0.856 -> 0.910 (commit deeed50)
//   [legs]  came with bent people keeping their legs; no measurement of masks on record (commit 3db21d5)
//   [stay]  came with ankles, sleeves and hands that stay; together: IoU p5 of 520 frames of seeds 70707, 60611
//           and 909090; only the figures before are on record: 0.9476, 0.9465, 0.9532 (commit cb455a6)
// None of them has a measurement of its own on record: the values were chosen on synthetic rooms.
#pragma once

namespace im2fit::segment::furniture_limits {

// Where a ledge, the level upper edge of a piece of furniture, may be.
inline constexpr float kLedgeLowMm = 130.0F;          // above the floor, least; shoes are lower; [cut]
inline constexpr float kLedgeHighMm = 800.0F;         // above the floor, most; hands hang above; 700 before [posts]
inline constexpr float kLedgeShare = 0.5F;            // most, of a standing person's height; 0.45 before [posts]
inline constexpr float kClearMm = 80.0F;              // above a ledge with nothing of the person; [cut]
inline constexpr float kLevelStepMm = 28.0F;          // height difference from column to column, most; [cut]
inline constexpr float kLevelMm = 50.0F;              // height difference along a ledge, most; [cut]
inline constexpr float kLedgeMinMm = 110.0F;          // length, least; shorter edges stay on the person; [cut]
inline constexpr float kTopFaceMm = 30.0F;            // below the edge: still the upper face, seen from above; [cut]
inline constexpr int kFrontCells = 4;                 // averaged for the distance of a front; [cut]
inline constexpr int kEdgeCells = 2;                  // of either face, mixed at an edge; [cut]
inline constexpr float kFrontToleranceMm = 14.0F;     // a front leaves its distance by, most; [cut]
inline constexpr float kFrontToleranceQuanta = 0.8F;  // and by so many disparity steps; [cut]
inline constexpr float kFlatBaseMm = 50.0F;      // either side of a column; calves bulge by 25 mm over both; [cut]
inline constexpr float kFlatBulgeMm = 7.0F;      // over that base, most; boxes have none, calves 25; [cut]
inline constexpr float kFlatBulgeQuanta = 0.4F;  // and so many disparity steps, which noise adds; [cut]
inline constexpr float kBandMm = 60.0F;          // off a front's distance, in the floor band; [cut]

// A front that goes on beside its ledge.
inline constexpr float kBesideMm = 200.0F;             // as far as that; [cut]
inline constexpr float kBesideToleranceMm = 10.0F;     // off the front's line, most; [cut]
inline constexpr float kBesideToleranceQuanta = 0.4F;  // and so many disparity steps; [cut]

// Whether the person sits.
inline constexpr float kSeatedShare = 0.33F;     // ledges of the height as seated: the thighs are higher; [cut]
inline constexpr float kSeatShare = 0.36F;       // seats, between the thighs, of the same height; [cut]
inline constexpr float kSeatedMaxMm = 1450.0F;   // height of most who sit; [cut]
inline constexpr float kSeatedTallMm = 1600.0F;  // height of the tallest who sit, as high as others stand; [stay]
inline constexpr float kSeatedAheadMm = 250.0F;  // shins before the trunk of these: a step is shorter; [stay]
inline constexpr float kBendsMm = 60.0F;         // shins behind the trunk: a person who bends; [legs]
inline constexpr float kTrunkLow = 0.55F;        // the trunk begins, of a seated person's height; [cut]
inline constexpr float kTrunkHigh = 0.8F;        // and ends; [cut]
inline constexpr float kDistanceBinMm = 10.0F;   // of the histogram its median distance is read from; resolution
inline constexpr int kDistanceBins = 1000;       // of it: to 10 m, where depth ends; follows from kDepthMaxMm

// Seats and chair backs, of who sits.
inline constexpr float kPartMm = 22.0F;        // depth jump that parts a row, and a disparity step; [cut]
inline constexpr int kFlatCellsMin = 4;        // across a part of a row, to see its shape; [cut]
inline constexpr float kRowFlatMm = 5.0F;      // bulge of a flat part, most; [cut]
inline constexpr float kRowRoundMm = 10.0F;    // bulge of a shin, least; [posts]
inline constexpr float kRowQuanta = 0.4F;      // and so many disparity steps, of both; [cut]
inline constexpr float kBehindMm = 150.0F;     // a backrest behind the trunk's front: trunks are 230 deep; [cut]
inline constexpr float kArmBehindMm = 150.0F;  // beyond that an arm reaches, most; [stay]
inline constexpr float kArmStepMm = 8.0F;      // depth step within an arm's surface, most; [stay]
inline constexpr float kArmStepQuanta = 0.5F;  // and so many disparity steps; [stay]

// Legs of chairs, and shins that are none.
inline constexpr float kPostMm = 50.0F;           // width, most; shins are wider; [posts]
inline constexpr float kPostLowMm = 200.0F;       // above the floor, least: ankles are as narrow; [posts]
inline constexpr float kPostTallMm = 60.0F;       // height, least: ankles seen that narrow are shorter; [stay]
inline constexpr float kShinThickMinMm = 70.0F;   // area over height of a shin on its own, least; [stay]
inline constexpr float kShinThickMaxMm = 125.0F;  // and most; [stay]
inline constexpr float kShinTallMinMm = 120.0F;   // height of a shin on its own, least; [stay]

}  // namespace im2fit::segment::furniture_limits
