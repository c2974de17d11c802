// SPDX-License-Identifier: Apache-2.0
// Whether a detection may be measured, and if not, what the person should change.
#pragma once

#include "core/guidance.h"
#include "core/joints.h"
#include "perception/observe/lean.h"
#include "perception/segment/segment.h"

namespace im2fit {

// Which side of the person the camera sees. `side`: turned too far for either, by more than 18 degrees from both.
enum class ViewSide : int { unknown, front, back, side };

// From the line of shoulders and hips and `back_probability` (0..1: the tracker's, that the person is seen from
// behind; 0 where unknown). Joints whose left lies on the picture's left mean `back` by themselves. `unknown` when
// the joints span no line, or the probability does not decide (0.35..0.65).
ViewSide view_side(const JointSet& joints, const FloorPlane& floor, float back_probability = 0.0F);

// The arms whose hand is nearer to the hip joint than that of an arm held off the body. arm_gap.h is more exact where
// the mask shows the arm.
ArmSet hands_close(const JointSet& joints, const FloorPlane& floor);

// not_upright (by the lean where it is seen, else by the joints: corrected Eq. 1 and the floor), not_frontal (neither
// front nor back). Thresholds are three joint errors away from the pose of a person who tries to stand straight: one
// noisy joint must not refuse a good frame. The direction a bent person faces is not judged.
GuidanceSet pose_gate(const JointSet& joints, const FloorPlane& floor, ViewSide view, const Lean& lean = {});
// The topmost pixel of the mask over the floor; 0 where the floor is not known.
float mask_height_mm(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person);
// Someone who stands on straight legs and is smaller than all whom the models hold, by 50 mm and more: children hold
// their arms nearer to the trunk, in millimetres, than hands_close() asks for, and would never be measured to be
// told. Between, and above: estimate/plausibility.h.
bool stands_small(float height_mm, const JointSet& joints, const FloorPlane& floor);

// Which of those codes a frame supports, given the mask's guidance: joints in few or coarse pixels are guesses, a
// hand outside the picture has no place, front and back cannot be distinguished without a head, and without feet
// neither the floor nor the vertical is seen. First the person must stand where the pose can be seen.
GuidanceSet pose_codes_seen(GuidanceSet of_mask, ViewSide view);
// By the joints alone, arms_close too.
inline GuidanceSet pose_gate(const JointSet& joints, const FloorPlane& floor) {
  const GuidanceSet close = hands_close(joints, floor) != 0 ? static_cast<GuidanceSet>(Guidance::arms_close) : 0;
  return close | pose_gate(joints, floor, view_side(joints, floor));
}

}  // namespace im2fit
