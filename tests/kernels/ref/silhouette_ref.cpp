// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void silhouette_ref(DepthView depth, MaskView mask, Silhouette& out) {
  out = {};
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0) continue;
      const std::uint64_t z = depth.at(u, v);
      const bool first = out.count++ == 0;
      out.u_min = first ? u : std::min(out.u_min, u);
      out.u_max = first ? u : std::max(out.u_max, u);
      out.v_min = first ? v : std::min(out.v_min, v);
      out.v_max = v;
      out.sum_z += z;
      out.sum_uz += static_cast<std::uint64_t>(u) * z;
      out.sum_vz += static_cast<std::uint64_t>(v) * z;
    }
  }
}

}  // namespace im2fit
