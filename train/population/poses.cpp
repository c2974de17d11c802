// SPDX-License-Identifier: Apache-2.0
#include "train/population/poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "train/common/draw.h"
#include "train/population/reach.h"

namespace im2fit::lab {
namespace {

using body::Mat3f;
using body::Segment;

constexpr Vec3f kX{1, 0, 0};
constexpr Vec3f kY{0, 1, 0};
constexpr Vec3f kZ{0, 0, 1};

constexpr float kThighMostDeg = 10;  // of a seated thigh from level

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}
float gauss(Rng& rng, double sd) {
  return static_cast<float>(rng.normal() * sd);
}
Mat3f about(Vec3f axis, float degrees) {
  return body::rotation_about(axis, degrees);
}

// Where an arm points, in the chest's axes. Angles in degrees.
struct ArmAngles {
  float abduction = 0;   // from straight down, sideways
  float flexion = 0;     // then forwards
  float elbow = 0;       // bend
  float elbow_turn = 0;  // 0: the forearm bends forwards; 90: upwards and inwards along the arm's own turn
  float twist = 0;       // about the upper arm, skin only
};

ArmAngles draw_arm(StandingPose pose, Rng& rng, float spread_min_deg) {
  switch (pose) {
    case StandingPose::relaxed: {
      const float spread = std::clamp(draw(rng, spread_min_deg, spread_min_deg + 10), 12.0F, 25.0F);
      return {spread, gauss(rng, 4), std::clamp(10 + gauss(rng, 5), 2.0F, 25.0F), gauss(rng, 12), gauss(rng, 8)};
    }
    case StandingPose::a_pose:
      return {41 + gauss(rng, 6), gauss(rng, 5), std::clamp(30 + gauss(rng, 12), 2.0F, 60.0F), gauss(rng, 15),
              gauss(rng, 8)};
    case StandingPose::psi:
      return {90 + gauss(rng, 8), gauss(rng, 6), 88 + gauss(rng, 9), 90 + gauss(rng, 9), gauss(rng, 8)};
    case StandingPose::squat:
    case StandingPose::bent_knees:
    case StandingPose::arm_raised:
    case StandingPose::arms_out:
      return {draw(rng, 30, 40), gauss(rng, 4), std::clamp(8 + gauss(rng, 5), 2.0F, 20.0F), gauss(rng, 12),
              gauss(rng, 8)};
    case StandingPose::crossed:
    case StandingPose::seated:
    case StandingPose::bowed:
      return draw_arm(StandingPose::relaxed, rng, spread_min_deg);
    case StandingPose::free:
      break;
  }
  return {draw(rng, 10, 150), draw(rng, -20, 75), draw(rng, 0, 115), draw(rng, -45, 100), gauss(rng, 25)};
}

// `side`: +1 the left arm. Upper arm and forearm directions in the chest's axes.
std::array<Vec3f, 2> arm_directions(const ArmAngles& a, float side) {
  const Mat3f lift = about(kX, -a.flexion) * about(kZ, side * a.abduction);
  const Vec3f upper = lift * -kY;
  // Bending about the arm's own sideways axis brings the forearm forwards; turned by 90 about the upper arm it
  // brings it upwards and, for a level arm, straight up.
  const Vec3f hinge = about(upper, -side * a.elbow_turn) * (lift * kX);
  return {upper, about(hinge, -a.elbow) * upper};
}

class Builder {
 public:
  Builder(const body::Skeleton& rest, StandingPose pose, Rng& rng, const TrunkShape* shape)
      : rest_(rest), pose_(pose), free_arms_(pose == StandingPose::free), rng_(rng), shape_(shape) {}

  body::Pose build(float spread_min_deg) {
    trunk();
    if (pose_ == StandingPose::seated) {
      sit();
      seated_arms(spread_min_deg);
      return result_;
    }
    if (pose_ == StandingPose::crossed)
      crossed_arms(spread_min_deg);
    else
      arms(spread_min_deg);
    leg(Segment::left_upper_leg, 1);
    leg(Segment::right_upper_leg, -1);
    return result_;
  }

 private:
  bool free() const { return pose_ == StandingPose::free; }
  Mat3f& rotation(Segment s) { return result_.rotation[at(s)]; }
  Vec3f rest_direction(Segment s) const { return normalized(rest_.tail[at(s)] - rest_.head[at(s)]); }
  // x: nod, y: turn, z: side bend.
  Mat3f jitter(double sd_x, double sd_y, double sd_z) {
    const float x = gauss(rng_, sd_x), y = gauss(rng_, sd_y), z = gauss(rng_, sd_z);
    return about(kY, y) * about(kX, x) * about(kZ, z);
  }
  // Turns the segment so that its bone points along `direction`, by the smallest turn after its parent's.
  void point(Segment s, const Mat3f& parent, Vec3f direction) {
    rotation(s) = body::rotation_between(parent * rest_direction(s), direction) * parent;
  }

  void trunk() {
    if (pose_ == StandingPose::seated) {
      // Sitting tilts the pelvis back; the spine makes up for most of it.
      const float tilt = draw(rng_, 2, 16);
      rotation(Segment::pelvis) = about(kX, -tilt) * jitter(2, 2, 1.5);
      rotation(Segment::abdomen) = rotation(Segment::pelvis) * about(kX, tilt * 0.5F) * jitter(2.5, 2, 1.5);
      rotation(Segment::chest) = rotation(Segment::abdomen) * about(kX, tilt * 0.5F) * jitter(2.5, 2.5, 1.5);
      rotation(Segment::neck) = rotation(Segment::chest) * jitter(4, 4, 2);
      rotation(Segment::head) = rotation(Segment::neck) * jitter(5, 8, 3);
      return;
    }
    if (pose_ == StandingPose::bowed) {
      bow();
      return;
    }
    if (pose_ == StandingPose::squat) bent_knee_deg_ = draw(rng_, 30, 100);
    if (pose_ == StandingPose::bent_knees) bent_knee_deg_ = draw(rng_, 12, 45);
    rotation(Segment::pelvis) = about(kX, 0.12F * bent_knee_deg_) * (free() ? jitter(4, 0, 3) : jitter(1.5, 0, 1.0));
    rotation(Segment::abdomen) = rotation(Segment::pelvis) * (free() ? jitter(5, 5, 4) : jitter(1.5, 1.2, 1.0));
    rotation(Segment::chest) = rotation(Segment::abdomen) * (free() ? jitter(4, 5, 3) : jitter(1.5, 1.2, 1.0));
    rotation(Segment::neck) = rotation(Segment::chest) * (free() ? jitter(4, 6, 3) : jitter(3, 2, 1.5));
    rotation(Segment::head) = rotation(Segment::neck) * (free() ? jitter(6, 12, 4) : jitter(3, 4, 2));
  }

  // The hips bend most; the spine does the rest.
  void bow() {
    const float bend = draw(rng_, 24, 56);
    const float toward = draw(rng_, -110, 110) * std::numbers::pi_v<float> / 180;  // 0: forwards
    const Vec3f axis{std::cos(toward), 0, -std::sin(toward)};
    rotation(Segment::pelvis) = about(axis, 0.6F * bend) * jitter(2, 2, 2);
    rotation(Segment::abdomen) = about(axis, 0.22F * bend) * rotation(Segment::pelvis) * jitter(2, 3, 2);
    rotation(Segment::chest) = about(axis, 0.18F * bend) * rotation(Segment::abdomen) * jitter(2, 3, 2);
    rotation(Segment::neck) = rotation(Segment::chest) * jitter(6, 6, 4);
    rotation(Segment::head) = rotation(Segment::neck) * jitter(10, 12, 5);
    free_arms_ = rng_.index(2) == 0;
  }

  void arms(float spread_min_deg) {
    const StandingPose kind = free_arms_ ? StandingPose::free : pose_;
    // People lift both arms about alike: half of the calm classes' difference is shared.
    const ArmAngles both = draw_arm(kind, rng_, spread_min_deg);
    float raised = 0;  // no side
    if (pose_ == StandingPose::arm_raised) raised = rng_.index(2) == 0 ? 1.0F : -1.0F;
    for (const float side : {1.0F, -1.0F}) {
      const Segment shoulder = side > 0 ? Segment::left_shoulder : Segment::right_shoulder;
      ArmAngles own = draw_arm(kind, rng_, spread_min_deg);
      for (int tries = 0; free_arms_ && tries < 8 && in_trunk(own, side); ++tries)
        own = draw_arm(kind, rng_, spread_min_deg);
      if (!free_arms_)
        own = {(own.abduction + both.abduction) / 2, (own.flexion + both.flexion) / 2, (own.elbow + both.elbow) / 2,
               (own.elbow_turn + both.elbow_turn) / 2, own.twist};
      if (side == raised) own = {draw(rng_, 110, 170), draw(rng_, -10, 30), draw(rng_, 5, 45), 90, 0};
      arm(shoulder, own, side);
    }
  }

  // Hand or elbow inside the trunk's box, in the chest's axes about the spine at shoulder height.
  bool in_trunk(const ArmAngles& a, float side) const {
    const std::size_t upper = at(side > 0 ? Segment::left_upper_arm : Segment::right_upper_arm);
    const Vec3f shoulder = rest_.head[upper];
    const auto directions = arm_directions(a, side);
    const float upper_length = norm(rest_.tail[upper] - shoulder);
    const float lower_length = norm(rest_.tail[upper + 1] - rest_.head[upper + 1]) * 1.35F;  // to the knuckles
    const float wide = std::fabs(shoulder.x) + 20;
    for (const float reach : {0.0F, 0.5F, 1.0F}) {
      const Vec3f p = shoulder + directions[0] * upper_length + directions[1] * (lower_length * reach);
      const float depth = p.z - shoulder.z;
      if (p.y < shoulder.y + 80 && std::fabs(p.x) < wide && depth < 190 && depth > -190) return true;
      if (side * p.x < -wide) return true;  // reached across the body
      if (p.y >= shoulder.y + 80 && std::fabs(p.x) < 160 && depth < 170 && depth > -170) return true;  // head
    }
    return false;
  }

  void arm(Segment shoulder, const ArmAngles& angles, float side) {
    const auto upper = static_cast<Segment>(at(shoulder) + 1);
    const auto lower = static_cast<Segment>(at(shoulder) + 2);
    const auto hand = static_cast<Segment>(at(shoulder) + 3);
    const Mat3f& chest = rotation(Segment::chest);
    // The shoulder blade rises with the arm: up to 14 degrees for a level arm.
    const float lift = std::clamp((angles.abduction - 45) / 45, 0.0F, 1.3F) * 12;
    rotation(shoulder) = chest * about(kZ, side * (lift + gauss(rng_, free_arms_ ? 3 : 1.5)));
    const auto directions = arm_directions(angles, side);
    const Vec3f upper_direction = chest * directions[0];
    point(upper, rotation(shoulder), upper_direction);
    rotation(upper) = about(upper_direction, side * angles.twist) * rotation(upper);
    point(lower, rotation(upper), chest * directions[1]);
    rotation(hand) = rotation(lower) * (free_arms_ ? jitter(12, 8, 12) : jitter(5, 3, 5));
  }

  void leg(Segment upper, float side) {
    const auto lower = static_cast<Segment>(at(upper) + 1);
    const auto foot = static_cast<Segment>(at(upper) + 2);
    const Mat3f& pelvis = rotation(Segment::pelvis);
    // Legs stay under the trunk: the pelvis' own sway moves them at half strength, calm feet keep flat.
    const Vec3f along = rest_direction(upper);
    const float swing = free() ? gauss(rng_, 12) : gauss(rng_, 1.5);
    const float stance = free() ? draw(rng_, -4, 14) : gauss(rng_, 2);
    const float knee = bent_knee_deg_ + std::fabs(free() ? gauss(rng_, 16) : gauss(rng_, 3));
    // A bent knee goes with a thigh brought forward by half of it, so that the foot stays below.
    // Of a squat the pelvis leans, which the thigh, relative to it, makes up for.
    const Mat3f turn = about(kX, -(swing + knee / 2 + 0.12F * bent_knee_deg_)) * about(kZ, side * stance);
    rotation(upper) = body::rotation_between(pelvis * along, normalized(turn * along)) * pelvis;
    const Mat3f toes = about(kY, side * (free() ? gauss(rng_, 8) : 3 + gauss(rng_, 5)));
    rotation(upper) = toes * rotation(upper);
    rotation(lower) = rotation(upper) * about(kX, knee);
    rotation(foot) = toes * (free() ? jitter(5, 0, 2) : jitter(1, 0, 0.5));
  }

  // --- arms on the body ---

  struct ArmBones {
    Segment shoulder, upper, lower, hand;
  };
  static ArmBones bones(float side) {
    const std::size_t first = at(side > 0 ? Segment::left_shoulder : Segment::right_shoulder);
    return {static_cast<Segment>(first), static_cast<Segment>(first + 1), static_cast<Segment>(first + 2),
            static_cast<Segment>(first + 3)};
  }

  // Points that move with the chest, posed and back.
  Vec3f with_chest(Vec3f rest_point) const {
    return rotation_of(Segment::chest) * (rest_point - rest_.head[at(Segment::chest)]) + chest_at();
  }
  Vec3f in_rest(Vec3f posed) const {
    return transpose(rotation_of(Segment::chest)) * (posed - chest_at()) + rest_.head[at(Segment::chest)];
  }
  Vec3f chest_at() const { return body::pose_skeleton(rest_, result_).head[at(Segment::chest)]; }
  const Mat3f& rotation_of(Segment s) const { return result_.rotation[at(s)]; }

  // Without a shape: an ellipse of 0.9 x 0.6 of the shoulders' half width.
  Vec3f on_trunk(float up, float angle_deg, float clear_mm) const {
    if (shape_ != nullptr) return shape_->point(up, angle_deg, clear_mm);
    const Vec3f left = rest_.head[at(Segment::left_upper_arm)], hip = rest_.head[at(Segment::left_upper_leg)];
    const float a = angle_deg * std::numbers::pi_v<float> / 180;
    return {(0.9F * left.x + clear_mm) * std::sin(a), hip.y + up * (left.y - hip.y),
            left.z + (0.6F * left.x + clear_mm) * std::cos(a)};
  }

  // Wrist to `wrist`, fingers along `fingers` as far as they lie flat on a surface of normal `out`, palm against it.
  // All posed.
  void lay_arm(float side, Vec3f wrist, Vec3f out, Vec3f fingers, Vec3f elbow_hint) {
    const ArmBones b = bones(side);
    rotation(b.shoulder) = rotation(Segment::chest) * about(kZ, side * gauss(rng_, 2));
    const Vec3f shoulder = body::pose_skeleton(rest_, result_).head[at(b.upper)];
    const float upper_mm = bone_mm(b.upper);
    const float lower_mm = bone_mm(b.lower);
    const auto inside = [&](Vec3f p) { return shape_ == nullptr ? -1000.0F : shape_->depth_inside(in_rest(p)); };
    const Reach r = reach_for(shoulder, upper_mm, lower_mm, wrist, elbow_hint, inside);
    point(b.upper, rotation(b.shoulder), r.upper);
    point(b.lower, rotation(b.upper), r.lower);
    const Vec3f flat = normalized(fingers - out * dot(fingers, out) + out * 0.05F);
    point(b.hand, rotation(b.lower), flat);
    // Half of the hand's turn about its own length is the forearm's.
    const Vec3f palm = rotation(b.hand) * Vec3f{side * kPalm.x, kPalm.y, kPalm.z};
    const Vec3f wanted = -out;
    const float turn =
        std::atan2(dot(cross(palm, wanted), flat), dot(palm, wanted)) * 180 / std::numbers::pi_v<float>;
    rotation(b.hand) = about(flat, turn) * rotation(b.hand);
    rotation(b.lower) = about(r.lower, std::clamp(turn, -110.0F, 110.0F) / 2) * rotation(b.lower);
  }

  void hand_on_trunk(float side, float up, float angle_deg, float clear_mm) {
    const Vec3f chest_point = on_trunk(up, angle_deg, clear_mm);
    const float a = angle_deg * std::numbers::pi_v<float> / 180;
    const Mat3f& chest = rotation(Segment::chest);
    const Vec3f out = chest * Vec3f{std::sin(a), 0, std::cos(a)};
    const Vec3f across = chest * Vec3f{-side * std::cos(a), draw(rng_, -0.3, 0.35), side * std::sin(a)};
    const Vec3f hint = chest * Vec3f{side * 0.75F, -0.75F, draw(rng_, -0.4, 0.1)};
    lay_arm(side, with_chest(chest_point), out, across, hint);
  }

  void hand_on_hip(float side) {
    const float angle = side * draw(rng_, 62, 88);
    const float a = angle * std::numbers::pi_v<float> / 180;
    const Mat3f& chest = rotation(Segment::chest);
    const Vec3f out = chest * Vec3f{std::sin(a), 0, std::cos(a)};
    const Vec3f fingers = chest * Vec3f{0, -0.6F, 0.8F};
    const Vec3f hint = chest * Vec3f{side, 0.1F, draw(rng_, -0.6, -0.1)};
    lay_arm(side, with_chest(on_trunk(draw(rng_, 0.12, 0.3), angle, 42)), out, fingers, hint);
  }

  void hanging_arm(float side, float spread_min_deg) {
    arm(bones(side).shoulder, draw_arm(StandingPose::relaxed, rng_, spread_min_deg), side);
  }

  void folded_arms() {
    const float up = draw(rng_, 0.48, 0.68);
    const float over = rng_.index(2) == 0 ? 1.0F : -1.0F;
    hand_on_trunk(-over, up - 0.03F, over * draw(rng_, 12, 30), 40);
    hand_on_trunk(over, up + 0.03F, -over * draw(rng_, 8, 24), 105);
  }

  void crossed_arms(float spread_min_deg) {
    const double kind = rng_.uniform();
    const float side = rng_.index(2) == 0 ? 1.0F : -1.0F;
    if (kind < 0.32) {
      hand_on_trunk(side, draw(rng_, 0.25, 0.8), side * draw(rng_, 2, 36), 38);
      hanging_arm(-side, spread_min_deg);
    } else if (kind < 0.6) {
      // One hand over the other where they meet.
      const float up = draw(rng_, 0.22, 0.5), apart = draw(rng_, 0.0, 0.2);
      hand_on_trunk(side, up, side * draw(rng_, 8, 32), 38);
      hand_on_trunk(-side, up + apart, -side * draw(rng_, 8, 32), apart < 0.12F ? 75.0F : 38.0F);
    } else if (kind < 0.8) {
      folded_arms();
    } else {
      hand_on_hip(side);
      if (rng_.uniform() < 0.7)
        hand_on_hip(-side);
      else
        hanging_arm(-side, spread_min_deg);
    }
  }

  // --- sitting ---

  // Both thighs are raised alike; then the leg whose foot would hang is lowered until it stands, too.
  void sit() {
    struct Leg {
      Segment upper;
      float side, abducted, toes, hip_y, thigh_mm, shank_mm;
      Vec3f shank;
    };
    const float raised = std::clamp(gauss(rng_, 3), -kThighMostDeg, kThighMostDeg) * std::numbers::pi_v<float> / 180;
    const body::PosedSkeleton posed = body::pose_skeleton(rest_, result_);
    std::array<Leg, 2> legs{};
    float floor_y = 1e9F;
    for (std::size_t i = 0; i < 2; ++i) {
      const float side = i == 0 ? 1.0F : -1.0F;
      const Segment upper = i == 0 ? Segment::left_upper_leg : Segment::right_upper_leg;
      const float abducted = draw(rng_, 1, 16);
      const Vec3f shank = about(kX, gauss(rng_, 7)) * (about(kZ, side * gauss(rng_, 4)) * -kY);
      const float toes = abducted * 0.6F + gauss(rng_, 6);
      legs[i] = {upper,
                 side,
                 abducted,
                 toes,
                 posed.head[at(upper)].y,
                 bone_mm(upper),
                 bone_mm(static_cast<Segment>(at(upper) + 1)),
                 shank};
      floor_y =
          std::min(floor_y, legs[i].hip_y + legs[i].thigh_mm * std::sin(raised) + legs[i].shank_mm * legs[i].shank.y);
    }
    for (const Leg& leg : legs) {
      const float rise = std::clamp((floor_y - leg.hip_y - leg.shank_mm * leg.shank.y) / leg.thigh_mm, -0.2F, 0.2F);
      const float a = leg.side * leg.abducted * std::numbers::pi_v<float> / 180;
      const float level = std::sqrt(1 - rise * rise);
      const auto lower = static_cast<Segment>(at(leg.upper) + 1);
      point(leg.upper, rotation(Segment::pelvis), {level * std::sin(a), rise, level * std::cos(a)});
      point(lower, rotation(leg.upper), leg.shank);
      rotation(static_cast<Segment>(at(leg.upper) + 2)) = about(kY, leg.side * leg.toes);
    }
  }
  float bone_mm(Segment s) const { return norm(rest_.tail[at(s)] - rest_.head[at(s)]); }

  void hand_on_thigh(float side) {
    const Segment leg = side > 0 ? Segment::left_upper_leg : Segment::right_upper_leg;
    const auto posed = body::pose_skeleton(rest_, result_);
    const Vec3f hip = posed.head[at(leg)], knee = posed.tail[at(leg)];
    const float radius = shape_ != nullptr ? shape_->thigh_radius_mm() : 75;
    const float inwards = rng_.uniform() < 0.3 ? draw(rng_, 30, 70) : draw(rng_, -10, 20);
    const Vec3f wrist =
        hip + (knee - hip) * draw(rng_, 0.42, 0.72) + kY * (radius + 30) - Vec3f{side * inwards, 0, 0};
    const Vec3f fingers = normalized(knee - hip) - Vec3f{side * draw(rng_, 0, 0.7), 0, 0};
    lay_arm(side, wrist, kY, fingers, {side * 0.8F, -0.3F, -0.5F});
  }

  void seated_arms(float spread_min_deg) {
    if (rng_.uniform() < 0.12) {
      folded_arms();
      return;
    }
    for (const float side : {1.0F, -1.0F}) {
      const double kind = rng_.uniform();
      if (kind < 0.68) {
        hand_on_thigh(side);
      } else if (kind < 0.8) {
        hand_on_trunk(side, draw(rng_, 0.3, 0.6), side * draw(rng_, 5, 32), side > 0 ? 38.0F : 70.0F);
      } else if (kind < 0.88) {
        hanging_arm(side, spread_min_deg);
      } else {
        // A gesture: the upper arm near the trunk, the forearm raised before it.
        const ArmAngles raised = {draw(rng_, 15, 50), draw(rng_, 5, 40), draw(rng_, 70, 125), draw(rng_, -20, 60),
                                  gauss(rng_, 15)};
        arm(bones(side).shoulder, raised, side);
      }
    }
  }

  // Out of the left palm at rest, found from the base mesh' hand (its flattest direction).
  static constexpr Vec3f kPalm{-0.5F, -0.8F, 0.33F};

  const body::Skeleton& rest_;
  StandingPose pose_;
  bool free_arms_;
  float bent_knee_deg_ = 0;  // both
  Rng& rng_;
  const TrunkShape* shape_;
  body::Pose result_;
};

}  // namespace

body::Pose draw_pose(const body::Skeleton& rest, StandingPose pose, Rng& rng, float arm_spread_min_deg,
                     const TrunkShape* trunk) {
  return Builder(rest, pose, rng, trunk).build(arm_spread_min_deg);
}

float draw_yaw_deg(StandingPose pose, Rng& rng) {
  switch (pose) {
    case StandingPose::free:
      return gauss(rng, 20);
    case StandingPose::crossed:
    case StandingPose::bowed:
      return gauss(rng, 10);
    case StandingPose::seated:
      return gauss(rng, 12);
    default:
      return gauss(rng, 4.5);
  }
}

float arm_spread_deg(float body_mass_index) {
  return std::clamp(12 + 0.55F * (body_mass_index - 24), 12.0F, 22.0F);
}

}  // namespace im2fit::lab
