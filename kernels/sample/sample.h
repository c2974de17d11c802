// SPDX-License-Identifier: Apache-2.0
// A depth image downsampled to cells of step x step pixels, one robust depth each.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr std::uint16_t kSampleDepthMaxMm =
    10000;  // range limit of structured light; 65535 and the like mean missing data

// Writes (width / step) x (height / step) depths, row by row: the lower median of those of a cell's five samples (its
// corners and the pixel at step / 2, step / 2) that have data, 0 where none has: 0 and values above
// kSampleDepthMaxMm are missing data. With step 1 the sample is the pixel. step >= 1; no allocation, thread-safe.
// Integers only: all tiers agree bit for bit.
using SampleFunction = void(DepthView depth, int step, std::uint16_t* out);
SampleFunction sample_portable, sample_neon, sample_avx2;
SampleFunction sample;  // the fastest here

using SampleKernel = KernelVariant<SampleFunction>;
inline constexpr SampleKernel kSampleKernels[] = {IM2FIT_PORTABLE(sample) IM2FIT_NEON(sample) IM2FIT_AVX2(sample)};

}  // namespace im2fit
