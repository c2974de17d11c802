// SPDX-License-Identifier: Apache-2.0
// Box, count and first moments of a mask's pixels.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

struct Silhouette {
  int count = 0;                                     // pixels
  int u_min = 0, u_max = -1, v_min = 0, v_max = -1;  // inclusive; these values without a pixel
  std::uint64_t sum_z = 0, sum_uz = 0, sum_vz = 0;   // of depth, and of column and row times depth
  bool operator==(const Silhouette&) const = default;
};

// Of the pixels with mask 255 (others 0). Depths under the mask are at most 32767 mm, sides at most kImageSideMax.
// No allocation, thread-safe. Integers only: all tiers agree bit for bit.
using SilhouetteFunction = void(DepthView depth, MaskView mask, Silhouette& out);
SilhouetteFunction silhouette_portable, silhouette_neon, silhouette_avx2;
SilhouetteFunction silhouette;  // the fastest here

using SilhouetteKernel = KernelVariant<SilhouetteFunction>;
inline constexpr SilhouetteKernel kSilhouetteKernels[] = {IM2FIT_PORTABLE(silhouette) IM2FIT_NEON(silhouette)
                                                              IM2FIT_AVX2(silhouette)};

}  // namespace im2fit
