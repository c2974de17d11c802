// SPDX-License-Identifier: Apache-2.0
// The constants of arm_gap.cpp: where a gap between arm and trunk is looked for, and what counts as one. Sources:
//   [ansur]  6,068 people of ANSUR II, between trochanter and acromion less 40 mm: buttock -.03 (SD .03), navel .31
//            (.04), midway from lowest rib to iliac crest .38 men, .40 women (.03), chest .76 (.04), crotch -.12
//            (.04), wrist of a hanging arm -.11 (.08)
//   [start]  330 starts of eight real people with hanging arms, 320x240 at 2.9 m: joined in all of 14,039 frames; 11
//   of
//            12 frames with arms apart are not
//   [eval]   200 people of im2fit-lab eval with arms 12 to 25 degrees off the body: 199 measured, 195 in clothes;
//   those
//            who are not do touch
//   [joints] one joint error (25 mm of shoulders and hips, 100 mm of hands): docs/tracker-evaluation.md
#pragma once

namespace im2fit::arm_gap_limits {

// Bands of the trunk, in shares of the way from the hip joints up to the shoulder joints. A band that is moved off
// its girth accepts people whose arm touches just there.
inline constexpr float kHipLow = -0.08F, kHipHigh = 0.12F;     // [ansur]
inline constexpr float kWaistLow = 0.25F, kWaistHigh = 0.45F;  // [ansur]
inline constexpr int kRows = 26;  // looked at from the waist's upper end to the hips' lower: 10 mm apart
// Of a band's rows that are seen, the share that must show a gap. Lower: wrinkles of sleeves open a gap for a row
// ([start]); higher: wrists bent inwards close one that is wide enough.
inline constexpr float kApartShareMin = 0.5F;
inline constexpr int kRowsMin = 3;  // seen in a band, least; below, nothing is said of it

inline constexpr float kNearMm = 200.0F;  // no camera of ours measures nearer (body/fit/sight.cpp)
inline constexpr float kTorsoMinMm = 250.0F,
                       kTorsoMaxMm = 900.0F;  // hips to shoulders; beyond, no joints of a person

// Widths, mm.
inline constexpr float kStartMm = 40.0F;     // from the spine to the first pixel with data, most: holes
inline constexpr float kGapMinMm = 15.0F;    // without the person between trunk and arm; a shadow of a structured
                                             // light sensor within one person is 5 mm; [start]
inline constexpr int kGapMinPx = 2;          // and in pixels: one is noise at outlines; [start]
inline constexpr float kStepMm = 70.0F;      // in depth, away from the camera: the arm is behind the trunk's edge
                                             // (kContourStepQ4 of kernels/contour)
inline constexpr float kArmMinMm = 25.0F;    // of an arm's piece, least: less is an outline's noise; half a wrist
inline constexpr float kTrunkMinMm = 80.0F;  // of the trunk's half width, least: holes nearer to the spine are none;
                                             // the slimmest waist measures 100
inline constexpr float kSearchMaxMm = 700.0F;  // from the spine: beyond, nothing of the arm hangs

// Of the lowest rows with a gap, the mean width above which the hand ends beside the hips, in the air: a hand that
// lies on the hip closes its gap row by row, by 10 mm each.
inline constexpr float kHandOutMm = 50.0F;
inline constexpr int kLowestRows = 3;

// Arms that are not beside the trunk at all.
inline constexpr float kAwayMin = 0.5F;   // outwards of the shoulder joint, in torso lengths: an upper arm raised
                                          // by 55 degrees or more; [joints]
inline constexpr float kAwayLow = 0.5F;   // rows where that is looked for, from ...
inline constexpr float kAwayHigh = 1.3F;  // ... to
inline constexpr int kAwayRows = 9;       // 50 mm apart

}  // namespace im2fit::arm_gap_limits
