// SPDX-License-Identifier: Apache-2.0
// The fast arithmetic of one pair; every tier must give its results. Inlined into portable's loop over a pair block.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/vec3.h"
#include "kernels/fpfh/fpfh_constants.h"

namespace im2fit::fpfh_detail {

// Bins of a pair with the source's normal u, the target's m and the line (dx, dy, dz) between them, packed
// f1 | f2 << 8 | f3 << 16, or negative where the careful path must decide.
//
// With d = q - p unnormalised and unit normals n1, n2, let A be +-n.d of the source the swap rule picks and T that of
// the target, c = n1.n2. Then |d x source|^2 = d2 - A^2 =: s, v.target = d.(n1 x n2)/sqrt(s) whichever is the source,
// and w.target = (T - A c)/sqrt(s).
inline std::int32_t pair_code(float dx, float dy, float dz, Vec3f u, Vec3f m) {
  const float d2 = dx * dx + dy * dy + dz * dz;
  const float along1 = u.x * dx + u.y * dy + u.z * dz;
  const float along2 = m.x * dx + m.y * dy + m.z * dz;
  const float c = u.x * m.x + u.y * m.y + u.z * m.z;
  const float triple = (dy * u.z - dz * u.y) * m.x + (dz * u.x - dx * u.z) * m.y + (dx * u.y - dy * u.x) * m.z;
  const float size1 = std::fabs(along1), size2 = std::fabs(along2);
  const bool swap = size1 < size2;
  const float source = swap ? -along2 : along1;
  const float target = swap ? -along1 : along2;
  const float s = d2 - source * source;
  const float v_length = std::sqrt(s > 0.0F ? s : 0.0F);
  const float d_length = std::sqrt(d2);
  const float inverse = 1.0F / (v_length * d_length);
  const float tie = kNearTie * d_length;
  const float f2 = triple * d_length * inverse * 5.5F + 5.5F;
  const float f3 = source * v_length * inverse * 5.5F + 5.5F;
  const float wt = target - source * c;
  const float across = std::fabs(wt);
  const float cl = c * v_length;
  int passed = 0;
  for (int k = 0; k < kEdgeCount; ++k) {
    passed += (across * kEdgeCosine[k] - cl * kEdgeSine[k] > 0.0F) ? 1 : 0;
  }
  const int b1 = wt < 0.0F ? 5 - passed : 5 + passed;
  // max(0, .) first: a NaN from 0/0 becomes 0 and stays in range; such pairs are careful ones anyway.
  const float low2 = f2 > 0.0F ? f2 : 0.0F, low3 = f3 > 0.0F ? f3 : 0.0F;
  const int b2 = static_cast<int>(low2 < 10.0F ? low2 : 10.0F);
  const int b3 = static_cast<int>(low3 < 10.0F ? low3 : 10.0F);
  const int careful = (s > kNearlyParallel * d2 ? 0 : -1) | (std::fabs(size1 - size2) <= tie ? -1 : 0);
  return (b1 | (b2 << 8) | (b3 << 16)) | careful;
}

}  // namespace im2fit::fpfh_detail
