// SPDX-License-Identifier: Apache-2.0
// The lines every picture of a skeleton is drawn of: each joint to its parent, and the hips to each other.
#pragma once

#include <array>
#include <cstddef>

#include "core/joints.h"

namespace im2fit {

struct DrawnBone {
  Joint from, to;
  Joint coloured_as;  // whose colour the line takes
};

inline constexpr auto kDrawnBones = [] {
  std::array<DrawnBone, kJointCount> bones{};
  bones[0] = {Joint::LH, Joint::RH, Joint::TO};
  for (std::size_t i = 1; i < kJointCount; ++i)
    bones[i] = {parent_of(kJointOrder[i]), kJointOrder[i], kJointOrder[i]};
  return bones;
}();

}  // namespace im2fit
