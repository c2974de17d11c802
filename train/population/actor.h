// SPDX-License-Identifier: Apache-2.0
// A person whose surface is not the body model's: a mesh of its own with bones and weights of its own. The bones are
// the body model's segments, so that poses are drawn alike.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "body/skeleton.h"
#include "core/joints.h"
#include "kernels/skin/skin.h"
#include "train/render/raster.h"

namespace im2fit::lab {

// The same of all people of a make.
struct ActorSurface {
  std::vector<Triangle> triangles;  // closed, counter-clockwise from outside
  std::vector<SkinRecord> skin;     // of each vertex
};

struct Actor {
  std::shared_ptr<const ActorSurface> surface;
  std::vector<Vec3f> rest;  // mm, y up, z front; as many as surface->skin
  body::Skeleton skeleton;  // of `rest`
};

// Linear blend skinning. `out` has as many places as the actor's rest mesh and is another memory.
void skin(const Actor& actor, const body::Pose& pose, std::span<Vec3f> out);
// OpenNI's fifteen, from the bones: HE is the middle of the head's, TO where the chest begins, LA and RA the ends of
// the hands' bones. Confidence 1.
JointSet joints_of(const Actor& actor, const body::Pose& pose);

}  // namespace im2fit::lab
