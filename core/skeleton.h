// SPDX-License-Identifier: Apache-2.0
// The tree the fifteen joints form: parents, mirror images, an order in which parents come first.
#pragma once

#include <array>

#include "core/joints.h"

namespace im2fit {

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
