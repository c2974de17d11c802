// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void average_ref(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
                 std::uint16_t* seen) {
  for (int i = 0; i < count; ++i) {
    const double z = depth[i];
    if (mask[i] == 0 || z == 0 || z > kFusedDepthMaxMm) continue;
    // In whole numbers: a mean of sum / seen would be rounded.
    if (seen[i] > 0 && std::fabs(z * seen[i] - sum[i]) > double{kOutlierMm} * seen[i]) continue;
    sum[i] += depth[i];
    ++seen[i];
  }
}

}  // namespace im2fit
