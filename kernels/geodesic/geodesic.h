// SPDX-License-Identifier: Apache-2.0
// Length of a line over a surface, given by points on it.
#pragma once

#include <cstdint>

#include "core/fixed.h"
#include "kernels/tier.h"

namespace im2fit {

using GeodesicMm = Fixed<std::int32_t, 7>;

// The length of the polyline through `count` points, in 1/128 mm: the sum of its steps' lengths, each rounded to the
// nearest 1/128 mm. x, y, z: GeodesicMm raws within +-2^30; the parts of a step saturate at +-256 mm (a surface seen
// that coarsely is another one): their squares' sum is at most 3 * 2^30, its root 56756, so 75,000 steps fit the
// result. Roots are rounded to the nearest, not down: what that adds and takes cancels. 0 for fewer than two points.
// Integers; ref, in double, differs by at most half a unit a step. No allocation,
// thread-safe.
using GeodesicFunction = std::uint32_t(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z,
                                       int count);
GeodesicFunction geodesic_portable, geodesic;

inline constexpr KernelVariant<GeodesicFunction> kGeodesicKernels[] = {IM2FIT_PORTABLE(geodesic)};

}  // namespace im2fit
