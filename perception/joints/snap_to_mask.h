// SPDX-License-Identifier: Apache-2.0
// Joints seen through: one beside the mask, where the camera sees farther than it, is not there.
#pragma once

#include "core/camera.h"
#include "core/vec3.h"
#include "perception/joints/view.h"

namespace im2fit::joints {

// The place at the same depth before the nearest masked pixel, at most kSnapReachMm away in the picture's plane;
// `p` itself where it lies on the mask, is hidden by a nearer surface, or has no mask in reach. `depth` is the whole
// picture, `view` the result of its downsample().
inline constexpr float kSnapReachMm = 100.0F;
Vec3f snap_to_mask(Vec3f p, const View& view, DepthView depth, const Intrinsics& intrinsics);

}  // namespace im2fit::joints
