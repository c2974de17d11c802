// SPDX-License-Identifier: Apache-2.0
#include "kernels/average/average.h"

namespace im2fit {

void average_portable(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
                      std::uint16_t* seen) {
  for (int i = 0; i < count; ++i) {
    const std::uint32_t z = depth[i];
    if (mask[i] == 0 || z == 0 || z > kFusedDepthMaxMm) continue;
    const std::uint32_t n = seen[i];
    if (z * n > sum[i] + kOutlierMm * n || z * n + kOutlierMm * n < sum[i]) continue;  // never when n is 0
    sum[i] += z;
    seen[i] = static_cast<std::uint16_t>(n + 1);
  }
}

void average(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
             std::uint16_t* seen) {
  IM2FIT_CHOSEN_ONCE best = fastest(kAverageKernels);
  best(depth, mask, count, sum, seen);
}

}  // namespace im2fit
