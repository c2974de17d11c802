// SPDX-License-Identifier: Apache-2.0
#include "kernels/mean/mean.h"

namespace im2fit {

void mean_portable(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed,
                   std::uint16_t* depth_q4, std::uint8_t* mask) {
  for (int i = 0; i < count; ++i) {
    const std::uint32_t n = seen[i];
    const bool keep = static_cast<int>(n) >= needed;
    mask[i] = keep ? 255 : 0;
    depth_q4[i] = keep ? static_cast<std::uint16_t>((sum[i] * 16U + n / 2U) / n) : std::uint16_t{0};
  }
}

void mean(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed, std::uint16_t* depth_q4,
          std::uint8_t* mask) {
  IM2FIT_CHOSEN_ONCE best = fastest(kMeanKernels);
  best(sum, seen, count, needed, depth_q4, mask);
}

}  // namespace im2fit
