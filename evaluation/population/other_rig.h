// SPDX-License-Identifier: Apache-2.0
// Bones, weights, parts and landmarks of the mesh of other_mesh.h, by rules of its own: the file has none. Everything
// hangs on vertices of the mesh, so that it follows where the mesh is deformed.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "body/skeleton.h"
#include "evaluation/population/body_dimensions.h"
#include "evaluation/population/other_mesh.h"
#include "train/population/actor.h"

namespace im2fit::lab {

struct OtherRig {
  DimensionSurface parts;
  std::shared_ptr<const ActorSurface> surface;
};
OtherRig make_other_rig(const OtherMesh& mesh);

// Joints of a deformed mesh: means of their vertices.
body::Skeleton bones_of(const DimensionSurface& parts, std::span<const Vec3f> rest);

}  // namespace im2fit::lab
