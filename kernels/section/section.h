// SPDX-License-Identifier: Apache-2.0
// The points of a picture that lie in cuts across the body, in the cuts' own planes.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/rayform/ray_form.h"
#include "kernels/tier.h"

namespace im2fit {

using SectionMm = Fixed<std::int32_t, 3>;                    // in the plane
using SectionOffMm = Fixed<std::int32_t, 5>;                 // off the plane
inline constexpr std::int32_t kSectionCoordinateMax = 4095;  // of |x|, |y| as SectionMm raws: 512 mm
inline constexpr int kSectionCountMax = 8;                   // cuts at once
inline constexpr int kSectionSlack = 8;                      // points written beyond a list's end
// Farther off its plane than this no point is within a tenth of its distance: 512 sqrt(2) / sqrt(99) mm.
inline constexpr std::int32_t kSectionOffMax = 74532;  // CoordinateMm raw: 72.79 mm

// As SectionMm raws.
struct SectionPoint {
  std::int16_t x, y;
};

// A cut: its centre's coordinates along the three axes, CoordinateMm raws within +-kFormOffsetMax / 2.
struct SectionCut {
  std::int32_t along, x, y;
};

// Tables of the body's axes (orthogonal): along it, and x and y in the cuts.
struct SectionScan {
  ImageView<const std::uint16_t> depth_q4;
  MaskView mask;
  const std::int32_t *along_columns, *along_rows;  // FormSlope raws
  const std::int32_t *x_columns, *x_rows;
  const std::int32_t *y_columns, *y_rows;
  const SectionCut* cuts;
  int cut_count;  // 1 .. kSectionCountMax
};

// Appends to each cut's list, in the order of rows and columns, the seen points (x, y) with |x|, |y| <=
// kSectionCoordinateMax that are off the plane by less than a tenth of their distance d from the centre:
//   100 off^2 < d^2 = off^2 + x^2 + y^2   as   99 off^2 < 16 (x^2 + y^2),
// off as SectionOffMm (1/32 mm), x and y as SectionMm (1/8 mm), both rounded half up from the products' 1/1024 mm.
// |off| <= 2330 and |x|, |y| <= 4095: either side below 2^29.1.
//
// points: for each cut room for `capacity` and kSectionSlack more, one list after the other; a list holds the first
// `capacity` points, counts[cut] of them. Values beyond the counts are undefined. Integers in all tiers, the same
// ones. `ref`, in double from the same tables, includes points on the wedge's border that rounding moves out, and the
// reverse: those with |10 |off| - d| < 0.3 mm.
using SectionFunction = void(const SectionScan& scan, SectionPoint* points, int capacity, int* counts);
SectionFunction section_portable, section_neon, section_avx2, section;

inline constexpr KernelVariant<SectionFunction> kSectionKernels[] = {IM2FIT_PORTABLE(section) IM2FIT_NEON(section)
                                                                         IM2FIT_AVX2(section)};

}  // namespace im2fit
