// SPDX-License-Identifier: Apache-2.0
// From the sums of several frames to their mean depth.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

// Pixels seen at least `needed` times (1 or more) get the mean (16 sum + seen / 2) / seen, in 1/16 mm and rounded
// half up, and mask 255; others 0 and 0. seen at most 4095 and sum at most 4095 seen. `count` pixels. No allocation,
// thread-safe. The quotient is exact: all tiers agree bit for bit.
using MeanFunction = void(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed,
                          std::uint16_t* depth_q4, std::uint8_t* mask);
MeanFunction mean_portable, mean_neon, mean_avx2;
MeanFunction mean;  // the fastest here

using MeanKernel = KernelVariant<MeanFunction>;
inline constexpr MeanKernel kMeanKernels[] = {IM2FIT_PORTABLE(mean) IM2FIT_NEON(mean) IM2FIT_AVX2(mean)};

}  // namespace im2fit
