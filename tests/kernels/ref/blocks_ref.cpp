// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void blocks_ref(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                std::uint16_t* count) {
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      std::vector<std::uint32_t> seen;
      for (int v = j * grid.step; v < (j + 1) * grid.step; ++v)
        for (int u = i * grid.step; u < (i + 1) * grid.step; ++u)
          if (mask.at(u, v) != 0 && depth_q4.at(u, v) != 0) seen.push_back(depth_q4.at(u, v));
      *sum_q4 = 0;
      *count = 0;
      for (const std::uint32_t d : seen) {
        if (d > *std::min_element(seen.begin(), seen.end()) + kSurfaceQ4) continue;
        *sum_q4 += d;
        ++*count;
      }
      ++sum_q4;
      ++count;
    }
  }
}

}  // namespace im2fit
