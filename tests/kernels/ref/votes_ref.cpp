// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void votes_ref(const VotingPoints& points, const float* q, Votes& out) {
  out = {};
  for (int i = 0; i < points.count; ++i) {
    const double inverse = -(double{q[0]} * points.ray_x[i] + double{q[1]} * points.ray_y[i] + double{q[2]});
    if (!(inverse > 1e-5)) continue;
    const double plane = 1 / inverse, z = points.z_mm[i];
    if (std::fabs(z - plane) < points.near_mm[i]) ++out.on;
    if (z > plane + 80 + points.far_mm[i]) ++out.behind;
  }
}

}  // namespace im2fit
