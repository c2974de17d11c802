// SPDX-License-Identifier: Apache-2.0
// The constants of edge_restorer.cpp.
#pragma once

#include <cstdint>

namespace im2fit::edge_restorer_limits {

// A floor below a camera at height h is seen to recede by z z/(f h) from pixel to pixel: what recedes faster than the
// floor of a camera as low as this is no surface people stand on.
inline constexpr int kCameraHeightLeastMm = 800;
inline constexpr int kSlopeLeastMm = 24;   // a pixel: noise of any sensor within 3 m stays below three quarters of it
inline constexpr int kFarthestMm = 20000;  // farther, the same: its square must fit

// A step that is repaired: less than a trunk's half depth, so that arms before the trunk count.
inline constexpr int kStepMinMm = 150;
// A step that is judged: the skin's own recession beside an outline, 55 mm in the last pixel of 256 across, is then
// less than the eighth below which a value is not called a bridge.
inline constexpr int kJudgedMinMm = 450;
inline constexpr int kBridgeEighths = 1;
// From surface to surface, in parts of the picture's long side: 10 px of 256. 5x5 pixels blended make five, a
// bilinear picture of a quarter of the resolution four, the skin's recession two more.
inline constexpr int kReachAcross = 25, kReachLeastPx = 8;
// Of them without data: four where 3x3 pixels were dropped beside flying ones.
inline constexpr int kGapAcross = 42, kGapLeastPx = 6;

inline constexpr int kSkinMm = 40;  // off its surface: as far as a mask follows it (kernels/membership)

// What lies between surfaces, as an angle: 3x3 pixels of 256 across blended make 2.1 px or 0.009, 5x5 4 px or 0.017,
// a hand at 2.3 m is 0.035 to 0.05 wide. Dropped beside time of flight's own flying pixels 3.7 px or 0.016, the same
// after a blend of 3x3 4.6 px or 0.020. im2fit-lab eval, 12 people a condition (docs/notebook/phones.md).
inline constexpr float kBridgeMostRad = 0.0125F, kGapMostRad = 0.0178F;

inline constexpr int kLineStep = 4;              // every fourth row and column is judged
inline constexpr std::uint32_t kJudgedMin = 60;  // steps, before anything is said: the rate is then within 0.1
// Every frame is judged until so many steps, which give rates within 0.03, or so many frames, 2 s, were seen. Then
// what is left to notice is a driver's setting that changes, and judging costs 2.9 M instructions (AArch64, 640x480).
inline constexpr std::uint32_t kJudgedEnough = 1024, kJudgedFrames = 60;
inline constexpr std::uint32_t kJudgeEvery = 8;
inline constexpr std::uint32_t kJudgedMany = 4096;  // then old ones count half: a driver's setting may change

}  // namespace im2fit::edge_restorer_limits
