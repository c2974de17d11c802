// SPDX-License-Identifier: Apache-2.0
// Rigid moves between a scene's axes.
#pragma once

#include "body/skeleton.h"
#include "core/vec3.h"

namespace im2fit::lab {

inline constexpr Vec3f kAxisX{1, 0, 0};
inline constexpr Vec3f kAxisY{0, 1, 0};
inline constexpr Vec3f kAxisZ{0, 0, 1};
inline constexpr double kFramesPerSecond = 30;

struct Rigid {
  body::Mat3f rotation;
  Vec3f translation;
  Vec3f operator()(Vec3f p) const { return rotation * p + translation; }
};
inline Rigid operator*(const Rigid& a, const Rigid& b) {
  return {a.rotation * b.rotation, a(b.translation)};
}

}  // namespace im2fit::lab
