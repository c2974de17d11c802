// SPDX-License-Identifier: Apache-2.0
// The directions of the limbs of a fitted pose. Girths are measured on a body in one standard pose, and the distance
// of the fitted pose from that changes the girths seen in a picture: raised shoulders narrow a chest.
#pragma once

#include <array>
#include <cstddef>

#include "body/skeleton.h"

namespace im2fit::body {

// Those that move the skin where girths are taken.
inline constexpr std::array kGirthLimbs = {Segment::left_shoulder,   Segment::left_upper_arm, Segment::right_shoulder,
                                           Segment::right_upper_arm, Segment::left_upper_leg, Segment::left_lower_leg,
                                           Segment::right_upper_leg, Segment::right_lower_leg};
inline constexpr std::size_t kLimbValues = 3 * kGirthLimbs.size();
using LimbAxes = std::array<float, kLimbValues>;

// Where the x axis of each of kGirthLimbs (towards the body's left in the rest pose, along shoulders and arms)
// points: its parts to the left, upwards and forwards of a body that faces as this one's pelvis does, -1..1. Those to
// the left and forwards are 0 for a pelvis that lies on its side, which faces nowhere.
LimbAxes limb_axes(const Pose& pose);

}  // namespace im2fit::body
