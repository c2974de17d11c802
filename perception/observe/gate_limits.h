// SPDX-License-Identifier: Apache-2.0
// The constants of gate.cpp: how far a pose may be from standing straight. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. One joint is some 20-40 mm off in a frame; shoulders and hips lie 350 and
// 200 mm apart. Sources:
//   [40]     true joints of 40 held-out people
//   [yaw]    people are learned within 13 degrees; the joints' yaw errs by 6
//   [joints] three joint errors from the pose of a person who stands straight
//   [none]   chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::gate_limits {

// Sine of the angle between neck-torso and torso-hips, most. The paper requires 0.1, but an upright person's own
// spine curves: median 0.16, maximum 0.32; [40]
inline constexpr float kLateralMax = 0.5F;
inline constexpr float kTiltMax = 0.26F;  // sine of the spine's tilt against the floor's normal: 15 degrees; [joints]
inline constexpr float kLeanMax = 0.19F;  // a trunk bent by 16 degrees, or all of the body by 11: observe/lean.h
// Sine of the shoulders' turn away from the camera, most: 12 degrees are too many to measure well, and 18 let pass
// all who stand within 12; [yaw]
inline constexpr float kYawMax = 0.309F;
inline constexpr float kHandGapMinMm = 60.0F;  // hand's distance sideways from the hip joint; [joints]
// The same of a hand the tracker hardly sees, which it puts where hands mostly are: 100 to 200 mm further out than it
// is, when it is before the body.
inline constexpr float kHandGapUnsureMinMm = 200.0F;
inline constexpr float kHandSureMin = 0.33F;   // confidence of a hand that is seen; [none]
inline constexpr float kAcrossMinMm = 100.0F;  // shoulders and hips together: some 500 mm apart; [none]
inline constexpr float kBackMin = 0.65F;       // probability of a back; [none]
inline constexpr float kFrontMax = 0.35F;      // and of a front, most; [none]

}  // namespace im2fit::gate_limits
