// SPDX-License-Identifier: Apache-2.0
// The constants of person_tracker.cpp: when a user counts as a person, and which user to follow. The effects of
// changes by 20 %: docs/notebook/perception.md. Sources:
//   [empty]  came with fewer false users: of 10,000 empty frames 226 before, 54 after, all changes together
//            (commit 3db21d5)
//   [ids]    came with ids, or with ids that last longer: 50 clips of two people who pass, 3 switches before, 0
//            after, all changes together (commits 9873af9, f1a81d9)
//   [odds]   came with log-odds of the shape (commit f771803): false users of 10,000 empty frames 10 before, 0
//            after
//   [613]    of 613 objects in 2,500 rooms that nothing learned from, four had a person score of 0.76, all with
//            log-odds below -4 (docs/tracker.md, Joints 6); false users: docs/tracker-evaluation.md
//   [mean]   of 2,000 furnished rooms (seed 777001, 20 frames each) the likeliest object had a mean of -1.7, the
//            likeliest that the segmenter confirmed -3.3; without a floor, 4,000 rooms, 0.6, the next -0.7 and
//            confirmed. Of real people (docs/notebook/tracker.md) 100 % of the calm and 92 % of those with
//            an arm up have more than -0.5; on no floor 100 and 82 % more than 1
//   [six]    two rooms of 667 had coats found by the mean of twelve frames, none of 200 turned or bent people was
//            (commit cb455a6)
//   [reach]  of 1,000 people with furniture about them none had anything above -0.7 within that reach; of 7 people
//            beside others who were not confirmed 5 were above
//   [rooms]  chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::person_tracker_limits {

// Evidence by shape.
inline constexpr int kSeenGain = 4;    // of a frame that shows a person there; one that does not costs 1; [empty]
inline constexpr int kConfirmed = 12;  // confirmed: three frames; [empty]
inline constexpr int kUnconfirmedBelow = 6;     // no longer confirmed; [rooms]
inline constexpr int kSeenMax = 32;             // confirmed for good; [ids]
inline constexpr int kShapeFramesMax = 12;      // of the mean of log-odds; [odds]
inline constexpr float kShapelessOdds = -3.0F;  // log-odds of a frame without a known shape; [odds]

// By joints: accepted at once, where the shape confirms the user too.
inline constexpr float kPersonScoreSure = 0.76F;           // JointTracker::person_score, least; [613]
inline constexpr float kPersonScoreSureShapeless = 0.82F;  // where the shape is unknown (cut off, far); [rooms]
inline constexpr float kOddsSure = -1.0F;                  // log-odds of the frame, least; [613]

// Accepted by several frames.
inline constexpr int kOddsFrames = 6;     // least; [six]
inline constexpr float kOddsMin = -0.5F;  // mean log-odds on a known floor, least; confirmed: kOddsSure; [mean]
inline constexpr float kOddsMinFloorless = 1.0F;  // and on none, where furniture comes nearer; [mean]

// Rejected.
inline constexpr int kLongFrames = 12;     // judged for so many, then rejected; the mean is of about as many; [six]
inline constexpr int kHopelessFrames = 4;  // a hopeless one for so many; [rooms]
inline constexpr float kHopelessOdds = -2.0F;  // mean log-odds below which it is hopeless; [rooms]

// Choice: the least cost, distance from the camera first.
inline constexpr float kAsideShare = 0.8F;              // of the distance aside; [rooms]
inline constexpr float kHeadlessMm = 700.0F;            // one without a head must be that much nearer; [rooms]
inline constexpr float kUnconfirmedCostMm = 20'000.0F;  // any confirmed user comes before a candidate
inline constexpr float kStayMm = 300.0F;                // advantage of the user chosen in the last frame; [rooms]
inline constexpr float kFarBehindMm = 1500.0F;  // a user further behind the person measured does not disturb; [rooms]
inline constexpr float kDisturbingOdds = 0.0F;  // log-odds of the shape of a candidate that disturbs; [reach]

}  // namespace im2fit::person_tracker_limits
