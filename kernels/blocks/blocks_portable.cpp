// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kernels/blocks/blocks.h"

namespace im2fit {
namespace {

struct Block {
  std::uint32_t sum = 0;
  std::uint16_t count = 0;
};

Block block_at(DepthView depth_q4, MaskView mask, int u0, int v0, int step) {
  constexpr std::uint32_t kNone = 65536;
  std::uint32_t nearest = kNone;
  for (int v = v0; v < v0 + step; ++v) {
    const std::uint16_t* d = depth_q4.row(v);
    const std::uint8_t* m = mask.row(v);
    for (int u = u0; u < u0 + step; ++u)
      if (m[u] != 0 && d[u] != 0) nearest = std::min<std::uint32_t>(nearest, d[u]);
  }
  Block block;
  if (nearest == kNone) return block;
  for (int v = v0; v < v0 + step; ++v) {
    const std::uint16_t* d = depth_q4.row(v);
    const std::uint8_t* m = mask.row(v);
    for (int u = u0; u < u0 + step; ++u) {
      if (m[u] == 0 || d[u] == 0 || d[u] > nearest + kSurfaceQ4) continue;
      block.sum += d[u];
      ++block.count;
    }
  }
  return block;
}

}  // namespace

void blocks_portable(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                     std::uint16_t* count) {
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      const Block block = block_at(depth_q4, mask, i * grid.step, j * grid.step, grid.step);
      *sum_q4++ = block.sum;
      *count++ = block.count;
    }
  }
}

void blocks(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4, std::uint16_t* count) {
  IM2FIT_CHOSEN_ONCE best = fastest(kBlocksKernels);
  best(depth_q4, mask, grid, sum_q4, count);
}

}  // namespace im2fit
