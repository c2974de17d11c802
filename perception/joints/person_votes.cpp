// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/person_votes.h"

#include <algorithm>

#include "core/joints.h"

namespace im2fit::joints {
namespace {

constexpr float kShapeUnit = 256.0F;
constexpr float kPersonScoreUnit = 4096.0F;

std::int16_t clue(float value) {
  return static_cast<std::int16_t>(std::clamp(value, -16000.0F, 16000.0F));
}

}  // namespace

void read_values(std::span<const Anchor> anchors, const View& view, const JointEstimate& estimate,
                 const Witness& witness, std::int16_t* out) {
  read_anchors(anchors, view, estimate.shape, out);
  std::int16_t* clues = out + anchors.size();
  clues[0] = 0;
  clues[1] = clue(kShapeUnit * witness.shape_odds);
  clues[2] = clue(kPersonScoreUnit * witness.person_score);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f p = joint_of(estimate.shape, static_cast<int>(j));
    const Vec3f parent = joint_of(estimate.shape, static_cast<int>(kJointParent[j]));
    const FloorPlane& floor = witness.floor;
    clues[static_cast<std::size_t>(kSpreadClues) + j] = clue(estimate.spread_mm[j]);
    clues[static_cast<std::size_t>(kBoneClues) + j] = clue(norm(p - parent));
    clues[static_cast<std::size_t>(kHeightClues) + j] =
        floor.known ? clue(dot(floor.up, p) + floor.camera_height_mm) : std::int16_t{0};
  }
}

}  // namespace im2fit::joints
