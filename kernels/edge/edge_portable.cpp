// SPDX-License-Identifier: Apache-2.0
#include "kernels/edge/edge_border.h"

namespace im2fit {
namespace {

struct Answer {
  unsigned far = 0, near = 0;  // 1 where a neighbour was
};

// Without branches, for the vectoriser.
inline void look(unsigned z, unsigned limit, unsigned other, Answer& answer) {
  const unsigned away = (other > z ? other : z) - (other > z ? z : other);
  const unsigned there = other != 0 ? 1 : 0, within = away <= limit ? 1 : 0;
  answer.near |= there & within;
  answer.far |= there & (within ^ 1);
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
      const unsigned z = here[u];
      const unsigned limit = 40 + ((z * z >> 16) * 18361 >> 16);
      Answer straight, slanting;
      look(z, limit, above[u], straight);
      look(z, limit, below[u], straight);
      look(z, limit, here[u - 1], straight);
      look(z, limit, here[u + 1], straight);
      look(z, limit, above[u - 1], slanting);
      look(z, limit, above[u + 1], slanting);
      look(z, limit, below[u - 1], slanting);
      look(z, limit, below[u + 1], slanting);
      const unsigned is_edge = straight.far | ((straight.near | slanting.near) ^ 1);
      out[u] = static_cast<std::uint8_t>((z != 0 ? 255 : 0) & (0 - is_edge));
    }
    edge_pixels(depth, mask, v, depth.width - 1, depth.width);
  }
}

void edge(DepthView depth, MaskImage mask) {
  IM2FIT_CHOSEN_ONCE best = fastest(kEdgeKernels);
  best(depth, mask);
}

}  // namespace im2fit
