// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/gate.h"

#include <cmath>

#include "core/joints.h"
#include "perception/paper/paper.h"
#include "perception/profile/person_frame.h"

// The thresholds of this file: how far a pose may be from standing straight. What breaks when one moves by 20 %:
// docs/notebook/perception.md. One joint is some 20-40 mm off in a frame; shoulders and hips lie 350 and
// 200 mm apart. Sources:
//   [40]     true joints of 40 held-out people
//   [yaw]    people are learned within 13 degrees; the joints' yaw errs by 6
//   [joints] three joint errors from the pose of a person who stands straight
//   [none]   chosen on synthetic rooms, no measurement on record
namespace im2fit::gate_limits {

// Sine of the angle between neck-torso and torso-hips, most. The paper requires 0.1, but an upright person's own
// spine curves: median 0.16, maximum 0.32; [40]
constexpr float kLateralMax = 0.5F;
constexpr float kTiltMax = 0.26F;  // sine of the spine's tilt against the floor's normal: 15 degrees; [joints]
constexpr float kLeanMax = 0.19F;  // a trunk bent by 16 degrees, or all of the body by 11: observe/lean.h
// Sine of the shoulders' turn away from the camera, most: 12 degrees are too many to measure well, and 18 let pass
// all who stand within 12; [yaw]
constexpr float kYawMax = 0.309F;
constexpr float kHandGapMinMm = 60.0F;  // hand's distance sideways from the hip joint; [joints]
// The same of a hand the tracker hardly sees, which it puts where hands mostly are: 100 to 200 mm further out than it
// is, when it is before the body.
constexpr float kHandGapUnsureMinMm = 200.0F;
constexpr float kHandSureMin = 0.33F;   // confidence of a hand that is seen; [none]
constexpr float kAcrossMinMm = 100.0F;  // shoulders and hips together: some 500 mm apart; [none]
constexpr float kBackMin = 0.65F;       // probability of a back; [none]
constexpr float kFrontMax = 0.35F;      // and of a front, most; [none]
// Of one who stands small: the survey's smallest adult of ANSUR II has 1409 mm. Knees before the middle of hips and
// feet, as a share of the height: 0.03 at most of 300 who stand, 0.075 and more of 24 who squat (2026-11-30).
constexpr float kSmallMaxMm = 1350;
constexpr float kSmallMinMm = 500;  // less is no child who stands
constexpr float kKneesForwardMax = 0.045F;

}  // namespace im2fit::gate_limits

namespace im2fit {

using namespace gate_limits;

namespace {

bool spine_tilted(const JointSet& joints, const PersonFrame& frame) {
  const Vec3f spine = normalized(joints[Joint::NE] - (joints[Joint::LH] + joints[Joint::RH]) * 0.5F);
  const float along = dot(spine, frame.up);
  const float tilt = std::sqrt(std::fmax(0.0F, 1.0F - along * along));
  return body_frame(joints).lateral > kLateralMax || along < 0 || tilt > kTiltMax;
}

}  // namespace

ViewSide view_side(const JointSet& joints, const FloorPlane& floor, float back_probability) {
  const PersonFrame frame = person_frame(floor, joints[Joint::TO]);
  // Hips turn with the shoulders; together they are steadier than either.
  const Vec3f across = (joints[Joint::LS] - joints[Joint::RS]) + (joints[Joint::LH] - joints[Joint::RH]);
  if (!(norm(across) >= kAcrossMinMm)) return ViewSide::unknown;
  if (std::abs(dot(normalized(across), frame.toward)) > kYawMax) return ViewSide::side;
  if (back_probability > kFrontMax && back_probability < kBackMin) return ViewSide::unknown;
  // Seen from behind, the person's left is the picture's left.
  return dot(across, frame.right) < 0 || back_probability >= kBackMin ? ViewSide::back : ViewSide::front;
}

GuidanceSet pose_codes_seen(GuidanceSet of_mask, ViewSide view) {
  if (has(of_mask, Guidance::too_near) || has(of_mask, Guidance::too_far) || has(of_mask, Guidance::too_noisy))
    return 0;
  GuidanceSet seen = 0;
  if (!has(of_mask, Guidance::feet_cut)) seen |= static_cast<GuidanceSet>(Guidance::not_upright);
  if (view == ViewSide::side || !has(of_mask, Guidance::head_cut))
    seen |= static_cast<GuidanceSet>(Guidance::not_frontal);
  if (!has(of_mask, Guidance::side_cut)) seen |= static_cast<GuidanceSet>(Guidance::arms_close);
  return seen;
}

ArmSet hands_close(const JointSet& joints, const FloorPlane& floor) {
  const PersonFrame frame = person_frame(floor, joints[Joint::TO]);
  // By the joints' own left and right, whatever the view: the gap is measured outwards.
  const bool facing = frame.side(joints[Joint::LS]) > frame.side(joints[Joint::RS]);
  const auto close = [&](Joint hand, Joint hip) {
    const float outwards = frame.side(joints[hand]) - frame.side(joints[hip]);
    const bool sure = joints.confidence[joint_index(hand)] >= kHandSureMin;
    return (facing == is_left(hand) ? outwards : -outwards) < (sure ? kHandGapMinMm : kHandGapUnsureMinMm);
  };
  return (close(Joint::LA, Joint::LH) ? kLeftArm : 0) | (close(Joint::RA, Joint::RH) ? kRightArm : 0);
}

float mask_height_mm(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person) {
  if (!person.floor.known) return 0;
  float top = 0;
  for (int u = person.u_min; u <= person.u_max; ++u) {
    if (mask.at(u, person.v_min) == 0) continue;
    const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(person.v_min),
                              static_cast<float>(depth.at(u, person.v_min)));
    top = std::fmax(top, dot(person.floor.up, p) + person.floor.camera_height_mm);
  }
  return top;
}

bool stands_small(float height_mm, const JointSet& joints, const FloorPlane& floor) {
  if (!(height_mm > kSmallMinMm && height_mm < kSmallMaxMm)) return false;
  const PersonFrame frame = person_frame(floor, joints[Joint::TO]);
  const auto depth_of = [&](Joint left, Joint right) {
    return frame.depth(joints[left]) + frame.depth(joints[right]);
  };
  const float knees = depth_of(Joint::LK, Joint::RK);
  const float ends = depth_of(Joint::LH, Joint::RH) + depth_of(Joint::LF, Joint::RF);
  return 0.5F * knees - 0.25F * ends < kKneesForwardMax * height_mm;
}

GuidanceSet pose_gate(const JointSet& joints, const FloorPlane& floor, ViewSide view, const Lean& lean) {
  GuidanceSet guidance = 0;
  const PersonFrame frame = person_frame(floor, joints[Joint::TO]);
  if (lean.seen ? lean.tangent > kLeanMax : spine_tilted(joints, frame))
    guidance |= static_cast<GuidanceSet>(Guidance::not_upright);
  else if (view != ViewSide::front && view != ViewSide::back)
    guidance |= static_cast<GuidanceSet>(Guidance::not_frontal);
  return guidance;
}

}  // namespace im2fit
