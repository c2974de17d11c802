// SPDX-License-Identifier: Apache-2.0
#include "synth/poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace im2fit::synth {
namespace {

using body::Mat3f;
using body::Segment;

constexpr Vec3f kX{1, 0, 0};
constexpr Vec3f kY{0, 1, 0};
constexpr Vec3f kZ{0, 0, 1};

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}
float gauss(Rng& rng, double sd) {
  return static_cast<float>(rng.normal() * sd);
}
float draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
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
  Builder(const body::Skeleton& rest, StandingPose pose, Rng& rng) : rest_(rest), pose_(pose), rng_(rng) {}

  body::Pose build(float spread_min_deg) {
    trunk();
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
    rotation(Segment::pelvis) = free() ? jitter(4, 0, 3) : jitter(1.5, 0, 1.0);
    rotation(Segment::abdomen) = rotation(Segment::pelvis) * (free() ? jitter(5, 5, 4) : jitter(1.5, 1.2, 1.0));
    rotation(Segment::chest) = rotation(Segment::abdomen) * (free() ? jitter(4, 5, 3) : jitter(1.5, 1.2, 1.0));
    rotation(Segment::neck) = rotation(Segment::chest) * (free() ? jitter(4, 6, 3) : jitter(3, 2, 1.5));
    rotation(Segment::head) = rotation(Segment::neck) * (free() ? jitter(6, 12, 4) : jitter(3, 4, 2));
  }

  void arms(float spread_min_deg) {
    // People lift both arms about alike: half of the calm classes' difference is shared.
    const ArmAngles both = draw_arm(pose_, rng_, spread_min_deg);
    for (const float side : {1.0F, -1.0F}) {
      const Segment shoulder = side > 0 ? Segment::left_shoulder : Segment::right_shoulder;
      ArmAngles own = draw_arm(pose_, rng_, spread_min_deg);
      for (int tries = 0; free() && tries < 8 && in_trunk(own, side); ++tries)
        own = draw_arm(pose_, rng_, spread_min_deg);
      if (!free())
        own = {(own.abduction + both.abduction) / 2, (own.flexion + both.flexion) / 2, (own.elbow + both.elbow) / 2,
               (own.elbow_turn + both.elbow_turn) / 2, own.twist};
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
    rotation(shoulder) = chest * about(kZ, side * (lift + gauss(rng_, free() ? 3 : 1.5)));
    const auto directions = arm_directions(angles, side);
    const Vec3f upper_direction = chest * directions[0];
    point(upper, rotation(shoulder), upper_direction);
    rotation(upper) = about(upper_direction, side * angles.twist) * rotation(upper);
    point(lower, rotation(upper), chest * directions[1]);
    rotation(hand) = rotation(lower) * (free() ? jitter(12, 8, 12) : jitter(5, 3, 5));
  }

  void leg(Segment upper, float side) {
    const auto lower = static_cast<Segment>(at(upper) + 1);
    const auto foot = static_cast<Segment>(at(upper) + 2);
    const Mat3f& pelvis = rotation(Segment::pelvis);
    // Legs stay under the trunk: the pelvis' own sway moves them at half strength, calm feet keep flat.
    const Vec3f along = rest_direction(upper);
    const float swing = free() ? gauss(rng_, 12) : gauss(rng_, 1.5);
    const float stance = free() ? draw(rng_, -4, 14) : gauss(rng_, 2);
    const float knee = std::fabs(free() ? gauss(rng_, 16) : gauss(rng_, 3));
    // A bent knee goes with a thigh brought forward by half of it, so that the foot stays below.
    const Mat3f turn = about(kX, -(swing + knee / 2)) * about(kZ, side * stance);
    rotation(upper) = body::rotation_between(pelvis * along, normalized(turn * along)) * pelvis;
    const Mat3f toes = about(kY, side * (free() ? gauss(rng_, 8) : 3 + gauss(rng_, 5)));
    rotation(upper) = toes * rotation(upper);
    rotation(lower) = rotation(upper) * about(kX, knee);
    rotation(foot) = toes * (free() ? jitter(5, 0, 2) : jitter(1, 0, 0.5));
  }

  const body::Skeleton& rest_;
  StandingPose pose_;
  Rng& rng_;
  body::Pose result_;
};

}  // namespace

body::Pose draw_pose(const body::Skeleton& rest, StandingPose pose, Rng& rng, float arm_spread_min_deg) {
  return Builder(rest, pose, rng).build(arm_spread_min_deg);
}

float draw_yaw_deg(StandingPose pose, Rng& rng) {
  return gauss(rng, pose == StandingPose::free ? 20 : 4.5);
}

float arm_spread_deg(float body_mass_index) {
  return std::clamp(12 + 0.55F * (body_mass_index - 24), 12.0F, 22.0F);
}

}  // namespace im2fit::synth
