// SPDX-License-Identifier: Apache-2.0
// How people stand: classes of poses with natural jitter.
#pragma once

#include <cstdint>

#include "body/skeleton.h"
#include "core/rng.h"
#include "train/population/trunk_shape.h"

namespace im2fit::lab {

enum class StandingPose {
  relaxed,   // arms held a little away from the body: abducted 12..25 degrees
  a_pose,    // the rest pose: upper arms 41 degrees from down, elbows bent
  psi,       // upper arms level, forearms up
  free,      // arms anywhere before the body and beside it, legs in stride, trunk bent and turned
  crossed,   // calm; one or both hands on belly, chest or hips, or folded arms
  seated,    // thighs level within 12 degrees, shanks upright, hands on the thighs, in the lap or beside
  bowed,     // trunk bent from the hips by 24..56 degrees, forwards or to a side; arms relaxed or as when free
  arms_out,  // the guided pose for arms that rest on the body when hanging: abducted 30..40 degrees, nearly straight
  squat,     // both knees bent by 30..100 degrees, feet flat, trunk a little forwards; arms as when arms_out
  bent_knees,  // the same with knees bent by 12..45 degrees
  arm_raised,  // one arm raised, 110..170 degrees from down, the elbow bent a little; the other as when arms_out
};

// The pose before the person's turn towards the camera (draw_yaw_deg). Elbows and hands of free poses keep out of
// the trunk. `arm_spread_min_deg`: least abduction of relaxed arms; heavy people need more (12 slim .. 22
// obese, see arm_spread_deg). The pelvis is not moved: put the lowest vertex on the floor after skinning.
// `trunk`: where hands of crossed and seated poses rest; without it, on a trunk of usual depth.
body::Pose draw_pose(const body::Skeleton& rest, StandingPose pose, Rng& rng, float arm_spread_min_deg = 12,
                     const TrunkShape* trunk = nullptr);
// The pose in mid-stride: `phase` turns per two steps, `strength` 0 (standing) .. 1 (brisk walk).
body::Pose striding(const body::Pose& standing, float phase, float strength);
// Turn about the vertical, + to the person's left: sd 4.5 degrees, free 20, crossed and bowed 10, seated 12.
float draw_yaw_deg(StandingPose pose, Rng& rng);
// By body mass index, kg/m^2.
float arm_spread_deg(float body_mass_index);

}  // namespace im2fit::lab
