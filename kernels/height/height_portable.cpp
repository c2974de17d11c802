// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "kernels/height/height.h"

namespace im2fit {
namespace {

static_assert(kHeightBinMm << CoordinateMm::kFractionBits == 1 << kHeightBinShift);

struct RowScan {
  const std::uint16_t* depth;
  const std::uint8_t* mask;
  std::int32_t up_row, side_row;
};

std::int32_t scan_pixels(const HeightScan& s, const RowScan& row, int begin, int end, std::int32_t lowest,
                         std::uint64_t* squares) {
  for (int u = begin; u < end; ++u) {
    const std::uint16_t depth = row.depth[u];
    if (row.mask[u] == 0 || depth == 0) continue;
    const std::int32_t side = form_product(s.side_columns[u] + row.side_row, depth) + s.side_offset;
    if (side >= s.side_max || side <= -s.side_max) continue;
    const std::int32_t height = form_product(s.up_columns[u] + row.up_row, depth) + s.up_offset;
    if (height < lowest) lowest = height;
    const std::int32_t bin = (height - kHeightMinMm * (1 << CoordinateMm::kFractionBits)) >> kHeightBinShift;
    if (bin >= 0 && bin < kHeightBins) squares[bin] += std::uint32_t{depth} * std::uint32_t{depth};
  }
  return lowest;
}

}  // namespace

std::int32_t height_portable(const HeightScan& s, std::uint64_t* squares) {
  std::memset(squares, 0, kHeightBins * sizeof *squares);
  std::int32_t lowest = kHeightNone;
  const int width = s.depth_q4.width;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    const RowScan row = {s.depth_q4.row(v), s.mask.row(v), s.up_rows[v], s.side_rows[v]};
    int u = 0;
    for (; u + 8 <= width; u += 8) {
      std::uint64_t masks;
      std::memcpy(&masks, row.mask + u, 8);
      if (masks != 0) lowest = scan_pixels(s, row, u, u + 8, lowest, squares);
    }
    lowest = scan_pixels(s, row, u, width, lowest, squares);
  }
  return lowest;
}

std::int32_t height(const HeightScan& scan, std::uint64_t* squares) {
  return height_portable(scan, squares);
}

}  // namespace im2fit
