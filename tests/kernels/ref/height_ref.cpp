// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

std::int32_t height_ref(const HeightScan& s, std::uint64_t* squares) {
  constexpr double kSlope = 1.0 / (1 << FormSlope::kFractionBits), kUnit = 1.0 / (1 << CoordinateMm::kFractionBits);
  std::fill_n(squares, kHeightBins, 0);
  double lowest = HUGE_VAL;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    for (int u = 0; u < s.depth_q4.width; ++u) {
      const std::uint16_t raw = s.depth_q4.at(u, v);
      if (s.mask.at(u, v) == 0 || raw == 0) continue;
      const double z = raw / 16.0;
      const auto along = [&](const std::int32_t* columns, const std::int32_t* rows, std::int32_t offset) {
        return z * kSlope * (double{1} * columns[u] + rows[v]) + kUnit * offset;
      };
      if (!(std::fabs(along(s.side_columns, s.side_rows, s.side_offset)) < kUnit * s.side_max)) continue;
      const double height = along(s.up_columns, s.up_rows, s.up_offset);
      lowest = std::min(lowest, height);
      const double bin = std::floor((height - kHeightMinMm) / kHeightBinMm);
      if (bin >= 0 && bin < kHeightBins)
        squares[static_cast<std::size_t>(bin)] += static_cast<std::uint64_t>(raw) * raw;
    }
  }
  return lowest < HUGE_VAL ? static_cast<std::int32_t>(std::lround(lowest / kUnit)) : kHeightNone;
}

}  // namespace im2fit
