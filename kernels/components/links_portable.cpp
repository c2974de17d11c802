// SPDX-License-Identifier: Apache-2.0
#include "kernels/components/links_edges.h"

namespace im2fit {

namespace {

// `bit` where cell and neighbour are one surface, without branches for the vectoriser. Closed cells have depth and
// limit 0: an open one is never that near.
std::uint16_t join(const LinkCells& cells, std::ptrdiff_t here, std::ptrdiff_t there, std::uint16_t bit) {
  const std::uint16_t za = cells.surface[here], zb = cells.surface[there];
  const std::uint16_t la = cells.limit[here], lb = cells.limit[there];
  const auto away = static_cast<std::uint16_t>((za > zb ? za : zb) - (za > zb ? zb : za));
  return away <= (la < lb ? la : lb) ? bit : std::uint16_t{0};
}
std::uint16_t where_hole(const LinkCells& cells, std::ptrdiff_t hole, std::uint16_t bits) {
  return cells.depth[hole] == 0 ? bits : std::uint16_t{0};
}

}  // namespace

void links_portable(const LinkCells& cells, std::uint8_t* links) {
  const std::ptrdiff_t width = cells.width;
  for (int r = 0; r < cells.height; ++r) {
    if (r + 2 >= cells.height || width < 4) {
      link_cells(cells, r, 0, cells.width, links);
      continue;
    }
    link_cells(cells, r, 0, 1, links);
    for (std::ptrdiff_t here = r * width + 1; here < r * width + width - 2; ++here) {
      const std::ptrdiff_t down = here + width;
      const int bits = join(cells, here, here + 1, kLinkRight) |
                       where_hole(cells, here + 1, join(cells, here, here + 2, kLinkRightOverHole)) |
                       join(cells, here, down, kLinkDown) |
                       where_hole(cells, down, join(cells, here, down + width, kLinkDownOverHole)) |
                       join(cells, here, down - 1, kLinkDownLeft) | join(cells, here, down + 1, kLinkDownRight);
      links[here] = static_cast<std::uint8_t>(cells.surface[here] != 0 ? bits : 0);
    }
    link_cells(cells, r, cells.width - 2, cells.width, links);
  }
}

void links(const LinkCells& cells, std::uint8_t* links) {
  IM2FIT_CHOSEN_ONCE best = fastest(kLinksKernels);
  best(cells, links);
}

}  // namespace im2fit
