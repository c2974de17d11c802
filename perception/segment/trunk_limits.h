// SPDX-License-Identifier: Apache-2.0
// The constants of trunk.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [legs]  of 57 people without a clear head 47 have such legs, of 240 pieces of furniture of a person's size
//           2 (commit 1e3516a)
//   [round] came with the same commit: of 1,000 empty frames 436 showed a user before, 3 after; all changes
//           together
//   [coats] coats on stands are no people (commit 78a99e4): chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::trunk_limits {

// Trunks: the bulge of their rows.
inline constexpr float kHalfMm = 180.0F;   // of a row, either side of the middle, most; [coats]
inline constexpr float kDepthMm = 280.0F;  // from the depth given: still the same surface; [round]
inline constexpr int kWidthMinCells = 6;   // of a row, least; [round]
inline constexpr int kRowsMin = 8;  // of a trunk or of legs, least: a disparity step of 20 mm then leaves 3; [round]
inline constexpr float kUnknownMisfit = 2.0F;      // of fewer rows; [round]
inline constexpr float kFlatShare = 2.0F;          // edge over bulge, of a bulge below 1 mm; [round]
inline constexpr float kBulgeMinMm = 18.0F;        // people have 18 to 80; [round]
inline constexpr float kBulgeMinSpreadMm = 8.0F;   // a misfit of 1 below that; [round]
inline constexpr float kBulgeMaxMm = 80.0F;        // and most; [round]
inline constexpr float kBulgeMaxSpreadMm = 30.0F;  // a misfit of 1 above that; [round]
inline constexpr float kEdgeShareMin = 0.58F;  // of the bulge, beyond half way: below, sides are straight; [round]
inline constexpr float kEdgeShareMinSpread = 0.2F;   // a misfit of 1 below that; [round]
inline constexpr float kEdgeShareMax = 0.93F;        // above, there is a step; [round]
inline constexpr float kEdgeShareMaxSpread = 0.08F;  // a misfit of 1 above that; [round]

// Legs: rows of the lower part.
inline constexpr float kLegWideMinMm = 80.0F;   // widest run of a row, mean, least; [legs]
inline constexpr float kLegWideMaxMm = 240.0F;  // and most, with trousers; [legs]
inline constexpr float kLegBulgeMinMm = 17.0F;  // middle before the edges, mean, least; [legs]
inline constexpr float kLegBulgeMaxMm = 75.0F;  // and most; [legs]
inline constexpr int kLegCellsMin = 4;          // of a row across a leg, to see it round; [legs]
inline constexpr float kLegRunsMin = 1.4F;      // runs of a row, mean, least: one leg or two; [legs]
inline constexpr float kLegRunsMax = 2.35F;     // and most; [legs]

}  // namespace im2fit::segment::trunk_limits
