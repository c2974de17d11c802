// SPDX-License-Identifier: Apache-2.0
// The constants of split_limbs.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [limbs]    came with legs under skirts and arms behind the trunk; tried on 250 furnished, dressed scenes,
//              no figures on record (commit 3dafe52)
//   [hands]    came with cut-off forearms: 4 of 100 free poses lost a limb or the person before (commit
//              9f75025)
//   [pointing] hands that point at the camera stay while cupboard corners are no heads (commit 37059cc)
//   [flat]     boxes on stools are no hands, IoU p5 0.9476, 0.9465, 0.9532 before; no figures after (commit
//              cb455a6)
//   [rooms]    chosen on synthetic rooms, no measurement on record
#pragma once

namespace im2fit::segment::split_limbs_limits {

// Hands and forearms before the body.
inline constexpr float kIslandAreaMaxM2 = 0.12F;    // of any limb, most: a forearm pointing at the camera; [hands]
inline constexpr float kForearmMaxMm = 600.0F;      // length with the hand, most; [hands]
inline constexpr float kForearmThickMinMm = 70.0F;  // area over length, least: table tops are thinner; [rooms]
inline constexpr float kForearmAreaMaxM2 = 0.08F;   // area, most; [hands]
inline constexpr float kHandHeightMinMm = 400.0F;   // above the floor, least: below stand boxes and chairs; [rooms]
inline constexpr float kFlatAreaMinM2 = 0.02F;      // a flat island that large is no palm; [flat]
inline constexpr float kFlatReliefMaxMm = 5.0F;     // relief below which it is flat; [flat]
inline constexpr float kFlatReliefQuanta = 0.3F;    // and so many disparity steps; [flat]
inline constexpr float kHandGapMaxMm = 280.0F;      // in space from the person, most: the forearm is hidden; [rooms]
inline constexpr float kPointingMm = 250.0F;        // before the body: may hide its whole arm; [pointing]
inline constexpr float kPointingGapMaxMm = 450.0F;  // gap then, most; [pointing]
inline constexpr float kHandMaxMm = 320.0F;         // length of a hand alone, most; [pointing]
inline constexpr float kElbowGapMaxMm = 100.0F;     // gap of others, most; [hands]
inline constexpr int kGapReachCells = 9;            // how far the person is searched about an island; [rooms]

// Arms and legs behind it.
inline constexpr float kLimbMinMm = 150.0F;       // length, least; [limbs]
inline constexpr float kLimbMaxMm = 900.0F;       // and most; [limbs]
inline constexpr float kLimbThickMinMm = 38.0F;   // area over length, least: legs of chairs are thinner; [limbs]
inline constexpr float kArmThickMaxMm = 95.0F;    // and most, of an arm; [limbs]
inline constexpr float kLegThickMaxMm = 120.0F;   // of a leg; [limbs]
inline constexpr float kLimbSlender = 1.6F;       // length over width, least; [limbs]
inline constexpr float kLimbReliefMinMm = 12.0F;  // from its best plane, least: fronts of boxes are flatter; [limbs]
inline constexpr float kArmGapMaxMm = 250.0F;     // in space, behind the trunk; [limbs]
inline constexpr float kLegGapMaxMm = 130.0F;     // behind the hem of a skirt; [limbs]
inline constexpr int kLimbTouchMin = 2;           // cells that touch the person, least; [limbs]
inline constexpr float kLegTopMaxMm = 1000.0F;    // a leg's top above the floor, most; [limbs]
inline constexpr float kLegEndMaxMm = 200.0F;     // and its end; [limbs]
inline constexpr float kArmEndMinMm = 350.0F;     // an arm's end above the floor, least; [limbs]

// What the outline encloses, and what lies on something else.
inline constexpr float kEnclosedMinMm = 400.0F;  // above the floor, least: boxes stand between legs; [limbs]
inline constexpr float kHeldMm = 120.0F;         // what goes on below is no further in depth than that; [limbs]

}  // namespace im2fit::segment::split_limbs_limits
