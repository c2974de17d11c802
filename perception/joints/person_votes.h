// SPDX-License-Identifier: Apache-2.0
// Person or object: trees over depths about the joints found, as for front or back, and over clues beside them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/camera.h"
#include "perception/joints/estimate.h"
#include "perception/joints/model_data.h"
#include "perception/segment/segment.h"

namespace im2fit::joints {

// What a frame's votes are counted on, beside the picture.
struct Witness {
  float shape_odds = 0;    // PersonTracker::shape_odds
  float person_score = 0;  // JointTracker's
  FloorPlane floor;
};

// By place among the clues: zero, to compare with; 256 x shape odds; 4096 x person_score; the joints' ensemble
// spread, mm; lengths of the bones to their parents, mm (the torso's is 0); heights above the floor, mm (0 where it
// is not known).
inline constexpr int kSpreadClues = 3;
inline constexpr int kBoneClues = kSpreadClues + static_cast<int>(kJointCount);
inline constexpr int kHeightClues = kBoneClues + static_cast<int>(kJointCount);
static_assert(kHeightClues + static_cast<int>(kJointCount) == kClueCount);

using VoteValues = std::array<std::int16_t, kPixelCountMax + kClueCount>;
// The anchors' depths, then the clues.
void read_values(std::span<const Anchor> anchors, const View& view, const JointEstimate& estimate,
                 const Witness& witness, std::int16_t* out);

}  // namespace im2fit::joints
