// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void floor_sums_ref(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count,
                    PlaneSums& out) {
  out = {};
  for (int i = 0; i < count; ++i) {
    const FloorCell& cell = cells[i];
    for (int v = cell.v; v < cell.v + step; v += cell.stride) {
      for (int u = cell.u; u < cell.u + step; u += cell.stride) {
        const std::uint16_t raw = depth.at(u, v);
        if (raw == 0 || raw > 10000) continue;
        // The gate in float, as its edge decides about whole pixels.
        const float z = raw;
        const float height = (gate.up_x * gate.ray_x[u] + gate.row_up[v]) * z + gate.camera_height_mm;
        if (std::fabs(height) > gate.flat_mm + gate.noise * z) continue;
        const double x = gate.ray_x[u], y = gate.ray_y[v], t = -1.0 / raw, w = cell.weight;
        const double a[6] = {x * x, x * y, x, y * y, y, 1}, b[3] = {t * x, t * y, t};
        for (int k = 0; k < 6; ++k) out.a[k] += w * a[k];
        for (int k = 0; k < 3; ++k) out.b[k] += w * b[k];
        out.weight += w;
      }
    }
  }
}

}  // namespace im2fit
