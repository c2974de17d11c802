// SPDX-License-Identifier: Apache-2.0
// A run of cells of one row with checked neighbour access, for the remainder at the borders of the picture.
// Included by each tier into its own translation unit.
#pragma once

#include <cstddef>

#include "kernels/components/links.h"

namespace im2fit {
namespace {

inline bool one_surface(const LinkCells& cells, std::ptrdiff_t a, std::ptrdiff_t b) {
  const int za = cells.surface[a], zb = cells.surface[b];
  const int limit = cells.limit[a] < cells.limit[b] ? cells.limit[a] : cells.limit[b];
  const int away = za > zb ? za - zb : zb - za;
  return za != 0 && zb != 0 && away <= limit;
}

inline void link_cells(const LinkCells& cells, int r, int c_begin, int c_end, std::uint8_t* links) {
  const std::ptrdiff_t width = cells.width;
  for (int c = c_begin; c < c_end; ++c) {
    const std::ptrdiff_t here = r * width + c, down = here + width;
    const bool right1 = c + 1 < cells.width, right2 = c + 2 < cells.width;
    const bool down1 = r + 1 < cells.height, down2 = r + 2 < cells.height;
    int bits = 0;
    if (cells.surface[here] != 0) {
      if (right1 && one_surface(cells, here, here + 1)) bits |= kLinkRight;
      if (right2 && cells.depth[here + 1] == 0 && one_surface(cells, here, here + 2)) bits |= kLinkRightOverHole;
      if (down1 && one_surface(cells, here, down)) bits |= kLinkDown;
      if (down2 && cells.depth[down] == 0 && one_surface(cells, here, down + width)) bits |= kLinkDownOverHole;
      if (down1 && c > 0 && one_surface(cells, here, down - 1)) bits |= kLinkDownLeft;
      if (down1 && right1 && one_surface(cells, here, down + 1)) bits |= kLinkDownRight;
    }
    links[here] = static_cast<std::uint8_t>(bits);
  }
}

}  // namespace
}  // namespace im2fit
