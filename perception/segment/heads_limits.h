// SPDX-License-Identifier: Apache-2.0
// The constants of heads.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [250]    each keeps 95 % of 250 dressed people's heads in furnished rooms (commit 1e3516a)
//   [corner] no second person in cupboard corners: SEVERAL_PEOPLE in 6 of 150 furnished rooms before, 0 or 1
//            after, all changes together (commit 37059cc)
//   [coats]  coats on stands are no people (commit 78a99e4): chosen on synthetic rooms, no measurement on
//            record
//   [rooms]  chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::heads_limits {

// Rows below the crown, mm, and what is measured in them.
inline constexpr float kGapBelowTopMm = 20.0F;    // a missing row so close to the top is noise; [rooms]
inline constexpr float kHeadBeginMm = 55.0F;      // the head is measured from here; [rooms]
inline constexpr float kHeadEndMm = 165.0F;       // to here, where the neck begins; [rooms]
inline constexpr float kCentreEndMm = 170.0F;     // the head's middle follows its rows down to here; [rooms]
inline constexpr float kNeckEndMm = 280.0F;       // the neck ends; [rooms]
inline constexpr float kTrunkBeginMm = 270.0F;    // the trunk and the shoulders begin; [250]
inline constexpr float kShouldersEndMm = 430.0F;  // the shoulders end; [rooms]
inline constexpr float kTrunkEndMm = 650.0F;      // the trunk is read to here; [coats]
inline constexpr float kHeadDepthMm = 280.0F;     // depth from the head's within which a row belongs to it; [rooms]
inline constexpr float kTrunkHalfMm = 180.0F;  // either side of the trunk's middle, where its bulge is read; [coats]

// Limits a head must keep.
inline constexpr float kHeadHeightMinMm = 1100.0F;  // above the floor, least: a seated adult's; [rooms]
inline constexpr float kNarrowestMinMm = 85.0F;     // width of its narrowest row, least; [250]
inline constexpr float kWidestMaxMm = 330.0F;       // of its widest row, most; [250]
inline constexpr float kWidthMinMm = 105.0F;        // mean width, least; [250]
inline constexpr float kWidthMaxMm = 270.0F;        // and most; [250]
inline constexpr float kNarrowestShareMin =
    0.45F;  // narrowest row over widest: below, it is cut in two or a corner; [corner]
inline constexpr float kNeckWidthMinMm = 90.0F;  // a neck below is a pole's; [rooms]
inline constexpr float kNeckShareMax = 1.25F;  // neck over head: above, it widens as a cupboard's top does; [corner]
inline constexpr float kShouldersMinMm = 220.0F;       // width of the shoulders, least; [250]
inline constexpr float kShouldersShareMin = 1.2F;      // over the head's, least; [250]
inline constexpr float kShoulderReachMinMm = 40.0F;    // beyond the head, least on the wider side; [250]
inline constexpr float kShoulderLackShareMax = 0.25F;  // of the head's width that one side may lack; [250]
inline constexpr float kHeadReliefMinMm =
    33.0F;  // heads recede by 50 to 65 mm to their outline, cupboard corners by 20; [corner]
inline constexpr float kHeadReliefQuanta = 0.2F;  // less so many disparity steps; [corner]
inline constexpr float kBackBulgeMinMm =
    10.0F;  // of the trunk, rms, least: some backs are as flat as a coat; [coats]
inline constexpr float kBackBulgeQuanta = 0.35F;  // and so many disparity steps; [coats]

// Misfit: by how much limits that most people keep are missed, summed in units of a spread.
inline constexpr float kMisfitMax = 1.0F;              // most; [250]
inline constexpr float kMisfitOnLegsMax = 3.0F;        // most of a surface that has legs; [250]
inline constexpr float kUsualWidthMm = 192.0F;         // heads are narrower, mostly; [250]
inline constexpr float kUsualNeckMm = 150.0F;          // necks are narrower, mostly; [250]
inline constexpr float kSpreadMm = 25.0F;              // unit of both; [250]
inline constexpr float kUsualShouldersShare = 2.2F;    // shoulders over head are more, mostly; [250]
inline constexpr float kShouldersShareSpread = 0.25F;  // unit of that; [250]

// Which heads count.
inline constexpr float kVagueMm =
    4500.0F;  // distance beyond which a head counts only where there is no better one; [corner]
inline constexpr float kVagueBulgeMm = 14.0F;     // trunk bulge below which it counts so; [rooms]
inline constexpr float kVagueBulgeQuanta = 0.5F;  // and so many disparity steps; [rooms]
inline constexpr float kPeakReachMm = 90.0F;      // a head's top is highest within that; [rooms]
inline constexpr float kHeadApartMm = 320.0F;     // between two heads of one surface, least; [rooms]

}  // namespace im2fit::segment::heads_limits
