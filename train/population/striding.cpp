// SPDX-License-Identifier: Apache-2.0
// Legs and arms of a walking person.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "train/population/poses.h"

namespace im2fit::lab {
namespace {

using body::Mat3f;
using body::Segment;

constexpr Vec3f kX{1, 0, 0};

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}
Mat3f about(Vec3f axis, float degrees) {
  return body::rotation_about(axis, degrees);
}

// Leg of one side half a turn after the other; the knee bends while the leg comes forward.
void swing_leg(body::Pose& pose, Segment upper, float phase, float strength) {
  const float turn = 2 * std::numbers::pi_v<float> * phase;
  const Mat3f hip = about(kX, -24 * strength * std::sin(turn));
  const float bend = 6 + 44 * std::max(0.0F, std::cos(turn));
  const Mat3f knee = hip * about(kX, bend * strength);
  Mat3f& thigh = pose.rotation[at(upper)];
  Mat3f& shank = pose.rotation[at(upper) + 1];
  Mat3f& foot = pose.rotation[at(upper) + 2];
  thigh = hip * thigh;
  shank = knee * shank;
  foot = about(kX, 0.5F * strength * (bend - 24 * std::sin(turn))) * foot;
}

void swing_arm(body::Pose& pose, Segment upper, float phase, float strength) {
  const float angle = 20 * strength * std::sin(2 * std::numbers::pi_v<float> * phase);
  for (std::size_t i = 0; i < 3; ++i) {
    Mat3f& r = pose.rotation[at(upper) + i];
    r = about(kX, -angle - (i > 0 ? 6 * strength : 0)) * r;
  }
}

}  // namespace

body::Pose striding(const body::Pose& standing, float phase, float strength) {
  body::Pose pose = standing;
  swing_leg(pose, Segment::left_upper_leg, phase, strength);
  swing_leg(pose, Segment::right_upper_leg, phase + 0.5F, strength);
  swing_arm(pose, Segment::left_upper_arm, phase + 0.5F, strength);
  swing_arm(pose, Segment::right_upper_arm, phase, strength);
  return pose;
}

}  // namespace im2fit::lab
