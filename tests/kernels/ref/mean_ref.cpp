// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void mean_ref(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed, std::uint16_t* depth_q4,
              std::uint8_t* mask) {
  for (int i = 0; i < count; ++i) {
    const bool keep = seen[i] >= needed;
    mask[i] = keep ? 255 : 0;
    // A double holds 2 x 16 sum + seen and the quotient's distance from a half is no less than 1 / (2 seen).
    depth_q4[i] = keep ? static_cast<std::uint16_t>(std::floor(16.0 * sum[i] / seen[i] + 0.5)) : std::uint16_t{0};
  }
}

}  // namespace im2fit
