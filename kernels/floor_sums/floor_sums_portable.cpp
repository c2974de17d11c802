// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kernels/floor_sums/floor_sums.h"

namespace im2fit {
namespace {

struct Row {
  float n = 0, x = 0, xx = 0, t = 0, tx = 0;
};

void add(PlaneSums& sums, const Row& row, float ray_y, float weight) {
  const double d = weight, y = ray_y, n = row.n, x = row.x, t = row.t;
  sums.a[0] += d * static_cast<double>(row.xx);
  sums.a[1] += d * x * y;
  sums.a[2] += d * x;
  sums.a[3] += d * n * y * y;
  sums.a[4] += d * n * y;
  sums.a[5] += d * n;
  sums.b[0] -= d * static_cast<double>(row.tx);
  sums.b[1] -= d * t * y;
  sums.b[2] -= d * t;
  sums.weight += d * n;
}

}  // namespace

void floor_sums_portable(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count,
                         PlaneSums& out) {
  PlaneSums sums;
  for (int i = 0; i < count; ++i) {
    const FloorCell& cell = cells[i];
    for (int v = cell.v; v < cell.v + step; v += cell.stride) {
      const std::uint16_t* raw = depth.row(v);
      const float row_up = gate.row_up[v];
      Row row;
      for (int u = cell.u; u < cell.u + step; u += cell.stride) {
        if (raw[u] == 0 || raw[u] > 10000) continue;
        const float z = static_cast<float>(raw[u]), x = gate.ray_x[u];
        const float height = (gate.up_x * x + row_up) * z + gate.camera_height_mm;
        if (std::fabs(height) > gate.flat_mm + gate.noise * z) continue;
        const float t = 1.0F / z;
        row.n += 1.0F;
        row.x += x;
        row.xx += x * x;
        row.t += t;
        row.tx += t * x;
      }
      add(sums, row, gate.ray_y[v], cell.weight);
    }
  }
  out = sums;
}

void floor_sums(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count, PlaneSums& out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kFloorSumsKernels);
  best(depth, step, gate, cells, count, out);
}

}  // namespace im2fit
