// SPDX-License-Identifier: Apache-2.0
// The sums a conic is fitted to: x^i y^j, i + j <= 4, of a section's points.
#pragma once

#include <cstdint>

#include "kernels/section/section.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kMomentCount = 15;
// The sum of x^i y^j: by degree, within one by falling power of x: 1, x, y, x^2, xy, y^2, x^3, ...
constexpr int moment_index(int i, int j) {
  return (i + j) * (i + j + 1) / 2 + j;
}
// kMomentPointsMax points at the corner reach 2^15 * 2^48 = 2^63.
inline constexpr int kMomentPointsMax = 32767;

// Sets kMomentCount sums over the points with first_x <= x <= last_x; |x|, |y| <= kSectionCoordinateMax, count <=
// kMomentPointsMax. Exact integers in all tiers, ref included: a double holds no 2^63.
using MomentsFunction = void(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums);
MomentsFunction moments_portable, moments;

inline constexpr KernelVariant<MomentsFunction> kMomentsKernels[] = {IM2FIT_PORTABLE(moments)};

}  // namespace im2fit
