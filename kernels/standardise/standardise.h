// SPDX-License-Identifier: Apache-2.0
// A feature in standard deviations of the training set, as fixed point.
#pragma once

#include <cstdint>

#include "core/fixed.h"
#include "kernels/tier.h"

namespace im2fit {

// Within +-5 standard deviations: one wild bin must not carry the answer. A step is 1/4096 of a standard deviation:
// far below the noise of any measured feature.
using StandardFeature = Fixed<std::int16_t, 12>;
inline constexpr float kStandardFeatureMax = 5.0F;
inline constexpr std::int16_t kStandardFeatureRawMax = 5 * 4096;

// out = (feature - mean) * scale in float32, clipped at +-5, to the nearest StandardFeature (ties to even); 0 where
// the feature is not a number. mean: finite; scale: 0 (the feature never varies: out is 0) or 2^-100 and more, so
// that an instruction set that takes denormal floats for zero gives the same (a product that small is rounded to 0
// anyway). Portable is within a step of ref: both are rounded, and two
// roundings of float32 below 8 (2^-21) may tip one of them over. No
// allocation, thread-safe.
using StandardiseFunction = void(const float* feature, const float* mean, const float* scale, int count,
                                 std::int16_t* out);
StandardiseFunction standardise_portable, standardise;

inline constexpr KernelVariant<StandardiseFunction> kStandardiseKernels[] = {IM2FIT_PORTABLE(standardise)};

}  // namespace im2fit
