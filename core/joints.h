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

}  // namespace im2fit
