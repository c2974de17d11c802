// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/side.h"

#include <array>
#include <utility>

#include "core/joints.h"

namespace im2fit::joints {

int side_score(const JointModel::Data& model, const View& view, const Shape& shape) {
  std::array<std::int16_t, kPixelCountMax> pixels;
  read_anchors(model.side.anchors, view, shape, pixels.data());
  return count_votes(model.side, pixels.data());
}

// 1 / (1 + exp(-x)) by exp(y) = lim (1 + y/n)^n at n = 256: no libm, the same bits everywhere; 3 % off at |x| = 4.
float chance_of_score(int score) {
  constexpr int kScoreMax = 12 * kVoteUnit;
  const int bounded = score > kScoreMax ? kScoreMax : (score < -kScoreMax ? -kScoreMax : score);
  float e = 1.0F - static_cast<float>(bounded) * (1.0F / static_cast<float>(kVoteUnit * 256));
  for (int i = 0; i < 8; ++i) e *= e;
  return 1.0F / (1.0F + e);
}

void swap_sides(JointSet& joints) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::size_t other = joint_index(kJointMirror[j]);
    if (other <= j) continue;  // its own image, or exchanged before
    std::swap(joints.position_mm[j], joints.position_mm[other]);
    std::swap(joints.confidence[j], joints.confidence[other]);
  }
}

}  // namespace im2fit::joints
