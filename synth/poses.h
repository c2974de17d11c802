// SPDX-License-Identifier: Apache-2.0
// How people stand: four classes of poses with natural jitter.
#pragma once

#include "base/rng.h"
#include "body/skeleton.h"

namespace im2fit::synth {

enum class StandingPose {
  relaxed,  // asked to hold the arms a little away from the body: abducted 12..25 degrees
  a_pose,   // the rest pose: upper arms 41 degrees from down, elbows bent
  psi,      // upper arms level, forearms up
  free,     // arms anywhere before the body and beside it, legs in stride, trunk bent and turned
};

// The pose before the person's turn towards the camera (draw_yaw_deg). Elbows and hands of free poses keep out of
// the trunk. `arm_spread_min_deg`: least abduction of relaxed arms; heavy people need more (facts: 12 slim .. 22
// obese, see arm_spread_deg). The pelvis is not moved: put the lowest vertex on the floor after skinning.
body::Pose draw_pose(const body::Skeleton& rest, StandingPose pose, Rng& rng, float arm_spread_min_deg = 12);
// Turn about the vertical, + to the person's left: sd 4.5 degrees, free 20.
float draw_yaw_deg(StandingPose pose, Rng& rng);
// By body mass index, kg/m^2.
float arm_spread_deg(float body_mass_index);

}  // namespace im2fit::synth
