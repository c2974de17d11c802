// SPDX-License-Identifier: Apache-2.0
// The fifteen OpenNI joints. Left and right are the person's own. LA/RA are the hands, LH/RH the hips.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "core/vec3.h"

namespace im2fit {

enum class Joint : int { HE, NE, TO, LS, RS, LE, RE, LA, RA, LH, RH, LK, RK, LF, RF };
inline constexpr std::size_t kJointCount = 15;
inline constexpr std::array<std::string_view, kJointCount> kJointNames = {
    "HE", "NE", "TO", "LS", "RS", "LE", "RE", "LA", "RA", "LH", "RH", "LK", "RK", "LF", "RF"};
constexpr std::size_t joint_index(Joint j) {
  return static_cast<std::size_t>(j);
}

struct JointSet {
  std::array<Vec3f, kJointCount> position_mm{};  // camera axes
  std::array<float, kJointCount> confidence{};   // 0..1: chance of being within 50 mm
  Vec3f& operator[](Joint j) { return position_mm[joint_index(j)]; }
  const Vec3f& operator[](Joint j) const { return position_mm[joint_index(j)]; }
};

// The tree the fifteen joints form: parents, mirror images, an order in which parents come first.

// The torso, then outwards.
inline constexpr std::array<Joint, kJointCount> kJointOrder = {Joint::TO, Joint::NE, Joint::HE, Joint::LS, Joint::RS,
                                                               Joint::LE, Joint::RE, Joint::LA, Joint::RA, Joint::LH,
                                                               Joint::RH, Joint::LK, Joint::RK, Joint::LF, Joint::RF};

// By joint; the torso is its own parent.
inline constexpr std::array<Joint, kJointCount> kJointParent = {
    Joint::NE, Joint::TO, Joint::TO, Joint::NE, Joint::NE, Joint::LS, Joint::RS, Joint::LE,
    Joint::RE, Joint::TO, Joint::TO, Joint::LH, Joint::RH, Joint::LK, Joint::RK};

// By joint: the same of the other side; itself in the middle.
inline constexpr std::array<Joint, kJointCount> kJointMirror = {
    Joint::HE, Joint::NE, Joint::TO, Joint::RS, Joint::LS, Joint::RE, Joint::LE, Joint::RA,
    Joint::LA, Joint::RH, Joint::LH, Joint::RK, Joint::LK, Joint::RF, Joint::LF};

constexpr Joint parent_of(Joint j) {
  return kJointParent[joint_index(j)];
}
constexpr Joint mirror_of(Joint j) {
  return kJointMirror[joint_index(j)];
}
// Of a pair the left joint has the smaller number.
constexpr bool is_left(Joint j) {
  return mirror_of(j) > j;
}
constexpr bool is_right(Joint j) {
  return mirror_of(j) < j;
}

}  // namespace im2fit
