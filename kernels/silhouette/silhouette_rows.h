// SPDX-License-Identifier: Apache-2.0
// From the rows of a mask to its silhouette: code shared by the hand-written tiers.
#pragma once

#include "kernels/silhouette/silhouette.h"

namespace im2fit {

struct SilhouetteRow {
  int count = 0, first = 0, last = -1;
  std::uint64_t z = 0, uz = 0;
};

// measure_row(depth, mask, width) gives the row of `width` pixels.
template <class MeasureRow>
Silhouette silhouette_of_rows(DepthView depth, MaskView mask, MeasureRow measure_row) {
  Silhouette s;
  for (int v = 0; v < mask.height; ++v) {
    const SilhouetteRow row = measure_row(depth.row(v), mask.row(v), mask.width);
    if (row.count == 0) continue;
    if (s.count == 0) s.v_min = v;
    if (s.count == 0 || row.first < s.u_min) s.u_min = row.first;
    if (row.last > s.u_max) s.u_max = row.last;
    s.v_max = v;
    s.count += row.count;
    s.sum_z += row.z;
    s.sum_uz += row.uz;
    s.sum_vz += row.z * static_cast<std::uint64_t>(v);
  }
  return s;
}

}  // namespace im2fit
