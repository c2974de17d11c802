// SPDX-License-Identifier: Apache-2.0
// Some pixels of one row, neighbours looked up with care. Included by each tier into its own translation unit.
#pragma once

#include <cstddef>

#include "kernels/edge/edge.h"

namespace im2fit {
namespace {

inline void edge_pixels(DepthView depth, MaskImage mask, int v, int u_begin, int u_end) {
  const std::ptrdiff_t stride = depth.stride;
  const std::uint16_t* row = depth.pixels + v * stride;
  for (int u = u_begin; u < u_end; ++u) {
    const std::uint32_t z = row[u];
    const std::uint32_t limit = 40 + ((z * z >> 16) * 18361 >> 16);
    bool jump = false, alone = true;
    for (int dv = v > 0 ? -1 : 0; dv <= (v + 1 < depth.height ? 1 : 0); ++dv) {
      for (int du = u > 0 ? -1 : 0; du <= (u + 1 < depth.width ? 1 : 0); ++du) {
        const std::uint32_t other = row[dv * stride + u + du];
        if (other == 0 || (du == 0 && dv == 0)) continue;
        const bool far = (other > z ? other - z : z - other) > limit;
        jump = jump || (far && (du == 0 || dv == 0));
        alone = alone && far;
      }
    }
    mask.pixels[std::ptrdiff_t{v} * mask.stride + u] = z != 0 && (jump || alone) ? 255 : 0;
  }
}

}  // namespace
}  // namespace im2fit
