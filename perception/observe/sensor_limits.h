// SPDX-License-Identifier: Apache-2.0
// The constants of sensor.cpp: when a user is accepted as a person. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [613]  of 613 objects in 2,500 rooms that nothing learned from, four had a person score of 0.76, all with
//          log-odds below -4 (docs/tracker.md, Joints 6); false users: docs/tracker-evaluation.md
//   [mean] of 2,000 furnished rooms (seed 777001, 20 frames each) the likeliest object had a mean of -1.7, the
//          likeliest that the segmenter confirmed -3.3; without a floor, 3,000 rooms, 0.3 (the next -0.9) and -2.5.
//          Of real people (docs/notebook/tracker-evaluation.md) 100 % of the calm and 92 % of those with an arm up
//          have more than -0.5; on no floor 100 and 86 % more than 0.5
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
inline constexpr int kOddsFrames = 6;     // least; [six]
inline constexpr float kOddsMin = -0.5F;  // mean log-odds on a known floor, least; confirmed: kOddsSure; [mean]
inline constexpr float kOddsMinFloorless = 0.5F;  // and on none, where furniture comes nearer; [mean]

// Rejected.
inline constexpr int kLongFrames = 12;     // judged for so many, then rejected; the mean is of about as many; [six]
inline constexpr int kHopelessFrames = 4;  // a hopeless one for so many; [none]
inline constexpr float kHopelessOdds = -2.0F;  // mean log-odds below which it is hopeless; [none]

// Holes.
inline constexpr float kLostShareMax = 0.30F;  // pixels without data: as in segment/advice_limits.h

}  // namespace im2fit::sensor_limits
