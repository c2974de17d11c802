// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void section_ref(const SectionScan& s, SectionPoint* points, int capacity, int* counts) {
  constexpr double kSlope = 1.0 / (1 << FormSlope::kFractionBits), kUnit = 1.0 / (1 << CoordinateMm::kFractionBits);
  constexpr double kSection = 1 << SectionMm::kFractionBits;
  for (int cut = 0; cut < s.cut_count; ++cut) counts[cut] = 0;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    for (int u = 0; u < s.depth_q4.width; ++u) {
      if (s.mask.at(u, v) == 0 || s.depth_q4.at(u, v) == 0) continue;
      const double z = s.depth_q4.at(u, v) / 16.0;
      const auto along = [&](const std::int32_t* columns, const std::int32_t* rows, std::int32_t centre) {
        return z * kSlope * (double{1} * columns[u] + rows[v]) - kUnit * centre;
      };
      for (int cut = 0; cut < s.cut_count; ++cut) {
        const SectionCut& c = s.cuts[cut];
        const double off = along(s.along_columns, s.along_rows, c.along), x = along(s.x_columns, s.x_rows, c.x),
                     y = along(s.y_columns, s.y_rows, c.y);
        const double rounded_x = std::floor(x * kSection + 0.5), rounded_y = std::floor(y * kSection + 0.5);
        if (std::fabs(rounded_x) > kSectionCoordinateMax || std::fabs(rounded_y) > kSectionCoordinateMax) continue;
        if (!(100 * off * off < off * off + x * x + y * y) || counts[cut] == capacity) continue;
        points[cut * (capacity + kSectionSlack) + counts[cut]++] = {static_cast<std::int16_t>(rounded_x),
                                                                    static_cast<std::int16_t>(rounded_y)};
      }
    }
  }
}

}  // namespace im2fit
