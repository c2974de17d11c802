// SPDX-License-Identifier: Apache-2.0
// Low shoes about the feet of a rest mesh.
#pragma once

#include <span>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "train/render/raster.h"

namespace im2fit::lab {

// Closed meshes that hold each foot up to the ankle: left, then right, the same number of vertices. `leather_mm`
// about the foot, `sole_mm` under it; toes end in one round cap.
void make_shoes(const body::BodyModel& model, std::span<const Vec3f> rest, const body::Skeleton& skeleton,
                float leather_mm, float sole_mm, std::vector<Vec3f>& vertices, std::vector<Triangle>& triangles);

}  // namespace im2fit::lab
