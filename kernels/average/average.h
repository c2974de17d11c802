// SPDX-License-Identifier: Apache-2.0
// One row of a frame on its way into the running mean of a standing person's depth.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

// Beyond this from the running mean a value belongs to another surface (a limb that moved, a flying pixel): five
// standard deviations of the sensor at 2.5 m.
inline constexpr std::uint32_t kOutlierMm = 50;
inline constexpr std::uint32_t kFusedDepthMaxMm = 4095;  // what 1/16 mm in 16 bits can hold

// Where mask is 255 and depth 1..4095 mm and within kOutlierMm of sum / seen (or seen is 0): adds the depth to sum
// and 1 to seen. `count` pixels; seen below 4095 and sum at most 4095 seen, so that every product fits 32 bits. No
// allocation, thread-safe. Integers only: all tiers agree bit for bit.
using AverageFunction = void(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
                             std::uint16_t* seen);
AverageFunction average_portable, average_neon, average_avx2;
AverageFunction average;  // the fastest here

using AverageKernel = KernelVariant<AverageFunction>;
inline constexpr AverageKernel kAverageKernels[] = {IM2FIT_PORTABLE(average) IM2FIT_NEON(average)
                                                        IM2FIT_AVX2(average)};

}  // namespace im2fit
