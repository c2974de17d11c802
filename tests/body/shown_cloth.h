// SPDX-License-Identifier: Apache-2.0
// Where a viewer shows the vertices of a garment that moves: offsets added at rest, then skinned (docs/garments.md).
#pragma once

#include <span>
#include <vector>

#include "garment/drape/cloth_part.h"
#include "garment/drape/refinement.h"

namespace im2fit::body {

// `offsets`: of the rough mesh; none: by the skeleton alone.
inline std::vector<Vec3f> shown_cloth(const ClothPart& part, std::span<const Refinement::Spot> spots,
                                      std::span<const Vec3f> offsets, const Skeleton& rest, const Pose& pose) {
  const PosedSkeleton posed = pose_skeleton(rest, pose);
  std::vector<Vec3f> out;
  for (std::size_t v = 0; v < part.rest.size(); ++v) {
    Vec3f at = part.rest[v], shown{};
    for (std::size_t k = 0; k < 3 && !offsets.empty(); ++k)
      at = at + offsets[static_cast<std::size_t>(spots[v].corner[k])] * spots[v].share[k];
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t s = part.segments[v][k];
      shown = shown + (posed.head[s] + pose.rotation[s] * (at - rest.head[s])) * part.weights[v][k];
    }
    out.push_back(shown);
  }
  return out;
}

}  // namespace im2fit::body
