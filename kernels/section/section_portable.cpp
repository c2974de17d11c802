// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstring>

#include "kernels/section/section.h"

namespace im2fit {
namespace {

constexpr int kOffShift = CoordinateMm::kFractionBits - SectionOffMm::kFractionBits;
constexpr int kPlaneShift = CoordinateMm::kFractionBits - SectionMm::kFractionBits;

template <int kShift>
std::int32_t rounded(std::int32_t a) {
  return (a + (1 << (kShift - 1))) >> kShift;
}
bool outside(std::int32_t a) {
  return a > kSectionCoordinateMax || a < -kSectionCoordinateMax;
}

struct Lists {
  SectionPoint* points;
  int capacity;
  int* counts;
};

void scan_pixels(const SectionScan& s, int v, int begin, int end, const Lists& lists) {
  const std::uint16_t* depths = s.depth_q4.row(v);
  const std::uint8_t* masks = s.mask.row(v);
  for (int u = begin; u < end; ++u) {
    const std::uint16_t depth = depths[u];
    if (masks[u] == 0 || depth == 0) continue;
    const std::int32_t along = form_product(s.along_columns[u] + s.along_rows[v], depth);
    for (int cut = 0; cut < s.cut_count; ++cut) {
      const SectionCut& c = s.cuts[cut];
      const std::int32_t off_plane = along - c.along;
      if (off_plane > kSectionOffMax || off_plane < -kSectionOffMax) continue;
      const std::int32_t x = rounded<kPlaneShift>(form_product(s.x_columns[u] + s.x_rows[v], depth) - c.x);
      const std::int32_t y = rounded<kPlaneShift>(form_product(s.y_columns[u] + s.y_rows[v], depth) - c.y);
      if (outside(x) || outside(y)) continue;
      const std::int32_t off = rounded<kOffShift>(off_plane);
      if (99 * off * off >= 16 * (x * x + y * y)) continue;
      int& count = lists.counts[cut];
      if (count == lists.capacity) continue;
      lists.points[cut * (lists.capacity + kSectionSlack) + count++] = {static_cast<std::int16_t>(x),
                                                                        static_cast<std::int16_t>(y)};
    }
  }
}

}  // namespace

void section_portable(const SectionScan& s, SectionPoint* points, int capacity, int* counts) {
  for (int cut = 0; cut < s.cut_count; ++cut) counts[cut] = 0;
  const Lists lists = {points, capacity, counts};
  const int width = s.depth_q4.width;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    const std::uint8_t* masks = s.mask.row(v);
    int u = 0;
    for (; u + 8 <= width; u += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, masks + u, 8);
      if (eight != 0) scan_pixels(s, v, u, u + 8, lists);
    }
    scan_pixels(s, v, u, width, lists);
  }
}

void section(const SectionScan& scan, SectionPoint* points, int capacity, int* counts) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSectionKernels);
  best(scan, points, capacity, counts);
}

}  // namespace im2fit
