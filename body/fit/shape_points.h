// SPDX-License-Identifier: Apache-2.0
// Which quads of the mesh the points of a shape space are the middles of: at equal steps of skin area, hands left
// out, because fingers are bent and no measurement uses them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "body/model.h"
#include "kernels/skin/skin.h"

namespace im2fit::body {

using Quad = std::array<std::int32_t, 4>;

// Weights of the corners added up, the four heaviest kept.
SkinRecord skin_of_quad(const BodyModel& model, const Quad& quad);
// At most `count`; fewer where a quad is larger than a step. `mesh`: the model's of no parameters.
std::vector<Quad> quads_at_equal_area(const BodyModel& model, std::span<const Vec3f> mesh, std::size_t count);
// Of the model's own shape space. Empty where it has none, or one whose points are not these.
std::vector<Quad> quads_of_shape_space(const BodyModel& model);

}  // namespace im2fit::body
