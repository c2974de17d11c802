// SPDX-License-Identifier: Apache-2.0
// The constants of floor.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [mount] how a camera may stand: the engine's promise, not a measurement
//   [steep] cameras that look down by 25 to 40 degrees found no floor before (commit c186dfc); no figures on
//           record
//   [rooms] chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::floor_limits {

// How a camera may stand.
inline constexpr float kUpXMax = 0.22F;  // sine of its roll: 12 degrees; [mount]
inline constexpr float kUpZMax = 0.42F;  // sine of its pitch: 25 degrees; [mount]
inline constexpr float kSteepUpZMax =
    0.64F;  // 40 degrees, where nothing else is found: seats and laps are level then; [steep]
inline constexpr float kCameraHeightMinMm = 420.0F;   // above the floor; [mount]
inline constexpr float kCameraHeightMaxMm = 2500.0F;  // and most; [mount]

// An accelerometer at rest is right to 1 degree, a plane through noisy cells to a few: 6 degrees; [rooms]
inline constexpr float kLevelCosineMin = 0.9945F;

// Level cells, and the search among them.
inline constexpr float kLevelSlope = 0.5F;       // rise over run in the picture's axes, most; [rooms]
inline constexpr float kSteepSlope = 0.9F;       // the same under a steep camera; [steep]
inline constexpr float kLevelRiseMm = 8.0F;      // and so much rise, which noise makes; [rooms]
inline constexpr float kLevelRunMaxMm = 800.0F;  // run, most: beyond, it is another surface; [rooms]
inline constexpr int kHypothesisCount = 120;     // planes tried; [rooms]
inline constexpr int kScoredCount = 400;         // cells that vote on each; [rooms]
inline constexpr float kBelowMm = 60.0F;         // and a disparity step, below a plane: speaks against it; [rooms]

// What a floor needs.
inline constexpr int kSupportMin = 60;             // cells, least; [rooms]
inline constexpr float kSupportWidthMm = 450.0F;   // across, least; [rooms]
inline constexpr float kSupportLengthMm = 250.0F;  // in depth, least; [rooms]
inline constexpr float kGateMm = 12.0F;            // off the plane, most; [rooms]
inline constexpr float kGateQuanta = 0.8F;         // and so many disparity steps, as heights; [rooms]
inline constexpr float kFirstPassShare = 1.5F;     // of the gate, in the pass that centres it; [rooms]
inline constexpr float kJumpMm = 12.0F;     // of the height at the feet, between frames: the camera moved; [rooms]
inline constexpr float kBandMm = 60.0F;     // from the coarse floor: cells of the precise fit; [rooms]
inline constexpr double kFrameKeep = 0.85;  // weight the frames before keep: about seven frames' worth; [rooms]
inline constexpr float kWeightMin = 30.0F;  // of the precise fit's cells, least; [rooms]

// A plane known is kept as long as cells lie on it: while no more than one in so many of those of its fit is lost, it
// is the floor. Once the average holds what it ever will (kFrameKeep^kWholeFrames = 0.2 is missing), a frame refines
// it with one in kRefineParts rows of cells, in turn, and keeps kFrameKeep^(1/kRefineParts) of those before, so that
// each row counts as much as ever.
inline constexpr int kKeepParts = 20;  // cells on a floor change by 1 % from frame to frame; [rooms]
inline constexpr int kWholeFrames = 10;
inline constexpr int kRefineParts = 4;
inline constexpr double kPartKeep = 0.9601845;

}  // namespace im2fit::segment::floor_limits
