// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kernels/votes/votes.h"

namespace im2fit {

void votes_portable(const VotingPoints& points, const float* q, Votes& out) {
  const float q0 = q[0], q1 = q[1], q2 = q[2];
  int on = 0, behind = 0;
  for (int i = 0; i < points.count; ++i) {
    const float inverse = -(q0 * points.ray_x[i] + q1 * points.ray_y[i] + q2);
    const float plane = 1.0F / inverse, z = points.z_mm[i];
    const bool meets = inverse > 1e-5F;
    on += static_cast<int>(meets) & static_cast<int>(std::fabs(z - plane) < points.near_mm[i]);
    behind += static_cast<int>(meets) & static_cast<int>(z > plane + 80.0F + points.far_mm[i]);
  }
  out = {on, behind};
}

void votes(const VotingPoints& points, const float* q, Votes& out) {
  votes_portable(points, q, out);
}

}  // namespace im2fit
