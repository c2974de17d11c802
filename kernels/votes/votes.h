// SPDX-License-Identifier: Apache-2.0
// How many points lie on a plane and how many behind it: the score of one guess in a search for a wall.
#pragma once

#include "kernels/tier.h"

namespace im2fit {

struct Votes {
  int on = 0;      // within near_mm in depth
  int behind = 0;  // farther than the plane + 80 mm + far_mm
};

// Points by ray (x/z, y/z) and depth, with their own limits; arrays of `count`.
struct VotingPoints {
  const float *ray_x, *ray_y, *z_mm, *near_mm, *far_mm;
  int count;
};

// The plane is q . (x/z, y/z, 1) = -1/z; rays that meet it beyond 100 m, or not at all, do not vote. Float, in this
// order: inverse = -((q0 x + q1 y) + q2), plane = 1 / inverse, |z - plane| < near, z > (plane + 80) + far. No
// allocation, thread-safe. Portable gives ref's counts but for points on an edge to 1e-3 mm.
using VotesFunction = void(const VotingPoints& points, const float* q, Votes& out);
VotesFunction votes_portable, votes;

using VotesKernel = KernelVariant<VotesFunction>;
inline constexpr VotesKernel kVotesKernels[] = {IM2FIT_PORTABLE(votes)};

}  // namespace im2fit
