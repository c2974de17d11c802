// SPDX-License-Identifier: Apache-2.0
#include "kernels/edge/edge_border.h"

namespace im2fit {
namespace {

// What a neighbour says, without branches for the vectoriser: bit 0 that it is near, bit 1 that it is far.
std::uint32_t look(std::uint32_t z, std::uint32_t limit, std::uint32_t other) {
  const std::uint32_t away = other > z ? other - z : z - other;
  return (other != 0 ? 1U : 0U) << (away > limit ? 1 : 0);
}

}  // namespace

void edge_portable(DepthView depth, MaskImage mask) {
  for (int v = 0; v < depth.height; ++v) {
    if (v == 0 || v + 1 == depth.height || depth.width < 3) {
      edge_pixels(depth, mask, v, 0, depth.width);
      continue;
    }
    const std::uint16_t *above = depth.row(v - 1), *here = depth.row(v), *below = depth.row(v + 1);
    std::uint8_t* out = mask.row(v);
    edge_pixels(depth, mask, v, 0, 1);
    for (int u = 1; u + 1 < depth.width; ++u) {
      const std::uint32_t z = here[u];
      const std::uint32_t limit = 40 + ((z * z >> 16) * 18361 >> 16);
      const std::uint32_t straight = look(z, limit, above[u]) | look(z, limit, below[u]) |
                                     look(z, limit, here[u - 1]) | look(z, limit, here[u + 1]);
      const std::uint32_t slanting = look(z, limit, above[u - 1]) | look(z, limit, above[u + 1]) |
                                     look(z, limit, below[u - 1]) | look(z, limit, below[u + 1]);
      const bool is_edge = (straight & 2U) != 0 || ((straight | slanting) & 1U) == 0;
      out[u] = z != 0 && is_edge ? 255 : 0;
    }
    edge_pixels(depth, mask, v, depth.width - 1, depth.width);
  }
}

void edge(DepthView depth, MaskImage mask) {
  IM2FIT_CHOSEN_ONCE best = fastest(kEdgeKernels);
  best(depth, mask);
}

}  // namespace im2fit
