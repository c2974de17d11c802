// SPDX-License-Identifier: Apache-2.0
// Smooth bumps of a skin: what people's principal components cannot express of one person. A bump moves the points
// about its centre along their normals, by a Gaussian of the distance. Together with the components they are the
// unknowns of a fit that sees a person all round (body/fit/turn_fitter.h).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "body/shape_space.h"
#include "core/vec3.h"

namespace im2fit::body {

// Of the mean body of a space; none lies on head, hands or feet. At most kBumpMax.
inline constexpr std::size_t kBumpMax = 256;
struct SkinBumps {
  explicit SkinBumps(const ShapeSpace& space);
  std::size_t count = 0;
  std::vector<Vec3f> normal;  // of each point of the space, unit, mean body at rest
  std::vector<float> move;    // point x count: mm along the normal for a coefficient of 1, its standard deviation
};

// The neighbours of each point on the skin: at most kSkinNeighbours, nearest first.
inline constexpr std::size_t kSkinNeighbours = 6;
struct SkinNeighbour {
  std::uint32_t point = 0;
  float distance_mm = 0;
};
struct SkinGraph {
  SkinGraph(const ShapeSpace& space, std::span<const Vec3f> normals);
  std::vector<SkinNeighbour> neighbours;  // point x kSkinNeighbours; distance 0: none
};

}  // namespace im2fit::body
