// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void links_ref(const LinkCells& cells, std::uint8_t* links) {
  for (int r = 0; r < cells.height; ++r) {
    for (int c = 0; c < cells.width; ++c) {
      const auto at = [&](int dc, int dr) {
        return static_cast<std::size_t>(r + dr) * static_cast<std::size_t>(cells.width) +
               static_cast<std::size_t>(c + dc);
      };
      const auto inside = [&](int dc, int dr) {
        return c + dc >= 0 && c + dc < cells.width && r + dr < cells.height;
      };
      const auto joined = [&](int dc, int dr) {
        if (!inside(dc, dr)) return false;
        const std::size_t a = at(0, 0), b = at(dc, dr);
        return cells.surface[a] != 0 && cells.surface[b] != 0 &&
               std::abs(cells.surface[a] - cells.surface[b]) <= std::min(cells.limit[a], cells.limit[b]);
      };
      const auto hole = [&](int dc, int dr) { return inside(dc, dr) && cells.depth[at(dc, dr)] == 0; };
      int bits = 0;
      if (joined(1, 0)) bits |= kLinkRight;
      if (hole(1, 0) && joined(2, 0)) bits |= kLinkRightOverHole;
      if (joined(0, 1)) bits |= kLinkDown;
      if (hole(0, 1) && joined(0, 2)) bits |= kLinkDownOverHole;
      if (joined(-1, 1)) bits |= kLinkDownLeft;
      if (joined(1, 1)) bits |= kLinkDownRight;
      links[at(0, 0)] = static_cast<std::uint8_t>(bits);
    }
  }
}

}  // namespace im2fit
