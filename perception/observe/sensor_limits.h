// SPDX-License-Identifier: Apache-2.0
// The constants of sensor.cpp: when a user is accepted as a person. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [613]  of 613 objects in 2,500 rooms that nothing learned from, four had a person score of 0.76, all with
//          log-odds below -4 (docs/tracker.md, Joints 6); false users: docs/tracker-evaluation.md
//   [mean] of 2,000 furnished rooms (seed 777001, 20 frames each) the likeliest object had a mean of -1.7, without a
//          floor -0.9; of 206 calm real people on a floor 100 % have more than -0.5, of 210 with an arm up 92 %; on
//          no floor 100 and 89 % more than 0 (notebook/tracker-evaluation.md, Real people). Odds that counted the
//          shape only had to exceed 1.5: 94 and 80 %, without a floor 69 and 33 %
//   [six]  two rooms of 667 had coats found by the mean of twelve frames, none of 200 turned or bent people was
//          (commit cb455a6)
//   [none] chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::sensor_limits {

// Accepted at once, where the segmenter confirms the user too.
inline constexpr float kPersonScoreSure = 0.76F;           // JointTracker::person_score, least; [613]
inline constexpr float kPersonScoreSureShapeless = 0.82F;  // where the shape is unknown (cut off, far); [none]
inline constexpr float kOddsSure = -1.0F;                  // log-odds of the frame, least; [613]

// Accepted by several frames.
inline constexpr int kOddsFrames = 6;             // least; [six]
inline constexpr float kOddsMin = -0.5F;          // mean log-odds, least, of who stands on a known floor; [mean]
inline constexpr float kOddsMinFloorless = 0.0F;  // and of who stands on none: furniture comes nearer; [mean]

// Rejected.
inline constexpr int kLongFrames = 12;     // judged for so many, then rejected; the mean is of about as many; [six]
inline constexpr int kHopelessFrames = 4;  // a hopeless one for so many; [none]
inline constexpr float kHopelessOdds = -2.0F;  // mean log-odds below which it is hopeless; [none]

// Holes.
inline constexpr float kLostShareMax = 0.30F;  // pixels without data: as in segment/advice_limits.h

}  // namespace im2fit::sensor_limits
