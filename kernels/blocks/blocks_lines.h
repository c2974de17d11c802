// SPDX-License-Identifier: Apache-2.0
// A row of blocks: down the pixel rows many columns at a time, then across each block. Included by each instruction
// set, which defines find_nearest and sum_columns for kLanes columns, into its own translation unit.
#pragma once

#include <cstddef>

#include "kernels/blocks/blocks.h"

namespace im2fit {
namespace {

// Column by column of pixels.
struct Lines {
  std::uint16_t nearest_less_1[kImageSideMax];  // 65535 where there is none
  std::uint16_t limit[kImageSideMax];           // 0 where there is none
  std::uint32_t sum[kImageSideMax];
  std::uint16_t count[kImageSideMax];
};

struct Rows {
  const std::uint16_t* depth;
  const std::uint8_t* mask;
  std::ptrdiff_t depth_stride, mask_stride;
  int step;
};

bool find_nearest(const Rows& rows, int u, Lines& lines);  // whether anything was seen
void sum_columns(const Rows& rows, int u, Lines& lines);

inline void find_nearest_one(const Rows& rows, int u, Lines& lines) {
  std::uint16_t nearest = 65535;
  for (int v = 0; v < rows.step; ++v) {
    const std::uint16_t d = rows.mask[v * rows.mask_stride + u] != 0 ? rows.depth[v * rows.depth_stride + u] : 0;
    const auto less = static_cast<std::uint16_t>(d - 1);
    nearest = less < nearest ? less : nearest;
  }
  lines.nearest_less_1[u] = nearest;
}

inline void sum_columns_one(const Rows& rows, int u, Lines& lines) {
  lines.sum[u] = lines.count[u] = 0;
  for (int v = 0; v < rows.step; ++v) {
    const std::uint16_t d = rows.depth[v * rows.depth_stride + u];
    if (rows.mask[v * rows.mask_stride + u] == 0 || d == 0 || d > lines.limit[u]) continue;
    lines.sum[u] += d;
    ++lines.count[u];
  }
}

// Each block's limit, for all its columns.
inline void spread_limits(int begin, int end, int step, Lines& lines) {
  for (int u0 = begin; u0 < end; u0 += step) {
    std::uint32_t nearest = 65535;
    for (int u = u0; u < u0 + step; ++u)
      nearest = lines.nearest_less_1[u] < nearest ? lines.nearest_less_1[u] : nearest;
    const std::uint32_t far = nearest + 1 + kSurfaceQ4;
    const std::uint32_t limit = nearest == 65535 ? 0 : far > 65535 ? 65535 : far;
    for (int u = u0; u < u0 + step; ++u) lines.limit[u] = static_cast<std::uint16_t>(limit);
  }
}

template <int kLanes>
void row_of_blocks(const Rows& rows, int columns, std::uint32_t* sum_q4, std::uint16_t* count, Lines& lines) {
  const int width = columns * rows.step;
  int first = width, last = 0;  // of the columns where something was seen
  for (int u = 0; u < width; u += kLanes) {
    const int end = u + kLanes < width ? u + kLanes : width;
    bool any = true;
    if (end - u == kLanes) {
      any = find_nearest(rows, u, lines);
    } else {
      for (int i = u; i < end; ++i) find_nearest_one(rows, i, lines);
    }
    if (!any) continue;
    first = u < first ? u : first;
    last = end;
  }
  for (int i = 0; i < columns; ++i) sum_q4[i] = count[i] = 0;
  if (first >= last) return;
  const int block_begin = first / rows.step, block_end = (last + rows.step - 1) / rows.step;
  const int begin = block_begin * rows.step, end = block_end * rows.step;
  spread_limits(begin, end, rows.step, lines);
  int u = begin;
  for (; u < end && u + kLanes <= width; u += kLanes) sum_columns(rows, u, lines);
  for (; u < end; ++u) sum_columns_one(rows, u, lines);
  for (int i = block_begin; i < block_end; ++i) {
    for (int k = i * rows.step; k < (i + 1) * rows.step; ++k) {
      sum_q4[i] += lines.sum[k];
      count[i] = static_cast<std::uint16_t>(count[i] + lines.count[k]);
    }
  }
}

template <int kLanes>
void all_blocks(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                std::uint16_t* count) {
  Lines lines;
  for (int j = 0; j < grid.rows; ++j) {
    const std::ptrdiff_t v = std::ptrdiff_t{j} * grid.step;
    const Rows rows = {depth_q4.pixels + v * depth_q4.stride, mask.pixels + v * mask.stride, depth_q4.stride,
                       mask.stride, grid.step};
    row_of_blocks<kLanes>(rows, grid.columns, sum_q4, count, lines);
    sum_q4 += grid.columns;
    count += grid.columns;
  }
}

}  // namespace
}  // namespace im2fit
