// SPDX-License-Identifier: Apache-2.0
// How a body stands to be dressed, and the way from one pose to another.
#pragma once

#include <span>

#include "body/model.h"
#include "body/skeleton.h"

namespace im2fit::body {

// Of the angles a body is dressed at.
inline constexpr float kRaisedArmCosine = 0.92718385F, kRaisedArmSine = 0.37460659F;  // 22 degrees below level
inline constexpr float kSpreadLegCosine = 0.97814760F, kSpreadLegSine = 0.20791169F;  // 12 degrees from upright
// Arms straight, 22 degrees below level; legs straight, 12 degrees from upright: nothing lies on anything.
Pose dressing_pose(const Skeleton& rest);
// `share` 0..1 of the way from `a` to `b`, each segment turning relative to its parent (normalised quaternions).
Pose between(const Pose& a, const Pose& b, float share);

// The place of the bones of each vertex of the body, mixed by its weights: the vertex is drawn in towards it. `out`:
// one place for each vertex wanted.
void bone_axes(const BodyModel& model, const PosedSkeleton& bones, std::span<const Vec3f> posed,
               std::span<Vec3f> out);

// A vertex of the body drawn in towards the bones, 1 for not at all, and flattened front to back about `middle_z`:
// the body on which a flat garment is put.
struct DrawnIn {
  float sideways = 1, depth = 1;
  float middle_z = 0;
};
void draw_in(const DrawnIn& drawn, std::span<const Vec3f> axes, std::span<const Vec3f> posed, std::span<Vec3f> out);

}  // namespace im2fit::body
