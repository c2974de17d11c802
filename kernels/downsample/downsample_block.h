// SPDX-License-Identifier: Apache-2.0
// One block, and the frame of a variant: rows of the box, vectors as far as they reach inside the picture.
#pragma once

#include <cstddef>

#include "kernels/downsample/downsample_box.h"

namespace im2fit::joints {
namespace {

struct DownsampleRow {
  const std::uint16_t* depth;  // first block's corner
  const std::uint8_t* mask;
  std::ptrdiff_t depth_stride, mask_stride;  // 0 when the block has one row only
};

inline std::uint16_t first_masked(const DownsampleRow& r, int step, int columns, int rows, std::ptrdiff_t u) {
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const std::uint16_t z = r.depth[y * r.depth_stride + u * step + x];
      if (z != 0 && r.mask[y * r.mask_stride + u * step + x] != 0) return z;
    }
  }
  return 0;
}

struct RowSums {
  std::uint32_t count = 0, z = 0;  // 2048 * 65535 < 2^27
  std::uint64_t uz = 0;
};

// whole(row, count, out, sums) handles the first n blocks of a row of `count` blocks that lie inside the picture
// entirely, and returns n.
template <class Whole>
inline void for_each_row(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments, Whole whole) {
  moments = {};
  const int step = box.step;
  for (int v = 0; v < box.height; ++v, out += box.width) {
    const int top = (box.v_first + v) * step, left = box.u_first * step;
    const int rows = box.depth.height - top < step ? box.depth.height - top : step;
    DownsampleRow row = {box.depth.pixels + std::ptrdiff_t{top} * box.depth.stride + left,
                         box.mask.pixels + std::ptrdiff_t{top} * box.mask.stride + left, box.depth.stride,
                         box.mask.stride};
    if (rows == 1) row.depth_stride = row.mask_stride = 0;
    const int inside = (box.depth.width - left) / step;
    RowSums sums;
    int u = whole(row, inside < box.width ? inside : box.width, out, sums);
    for (; u < box.width; ++u) {
      const int right = box.depth.width - left - u * step;
      const std::uint16_t z = first_masked(row, step, right < step ? right : step, rows, u);
      out[u] = z;
      sums.count += z != 0 ? 1 : 0;
      sums.z += z;
      sums.uz += static_cast<std::uint64_t>(z) * static_cast<std::uint64_t>(u);
    }
    moments.count += sums.count;
    moments.z += sums.z;
    moments.uz += static_cast<std::int64_t>(sums.uz);
    moments.vz += static_cast<std::int64_t>(sums.z) * v;
  }
}

// Sums of vectors: lane l of chunk c holds column lanes * c + l. `once` adds each chunk up, `again` adds `once` up
// after each chunk, so that again = sum of (n - c) z over the n chunks. 2048 columns, 256 chunks of 8, keep it below
// 2^32.
inline void add_lanes(const std::uint32_t* once, const std::uint32_t* again, int lanes, int chunks, RowSums& sums) {
  for (int l = 0; l < lanes; ++l) {
    sums.z += once[l];
    const std::uint64_t before = static_cast<std::uint64_t>(chunks) * once[l] - again[l];  // sum of c z
    sums.uz += static_cast<std::uint64_t>(lanes) * before + static_cast<std::uint64_t>(l) * once[l];
  }
}

}  // namespace
}  // namespace im2fit::joints
