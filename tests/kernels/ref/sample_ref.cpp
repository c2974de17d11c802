// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void sample_ref(DepthView depth, int step, std::uint16_t* out) {
  const int last = step - 1;
  for (int r = 0; r < depth.height / step; ++r) {
    for (int c = 0; c < depth.width / step; ++c) {
      std::array<std::uint16_t, 5> seen;
      seen.fill(65535);  // sorts last
      std::size_t count = 0;
      for (const auto& [u, v] : {std::pair(0, 0), {last, 0}, {step / 2, step / 2}, {0, last}, {last, last}}) {
        const std::uint16_t z = depth.at(c * step + u, r * step + v);
        if (z != 0 && z <= kSampleDepthMaxMm) seen[count++] = z;
      }
      std::sort(seen.begin(), seen.end());
      *out++ = count == 0 ? std::uint16_t{0} : seen[(count - 1) / 2];
    }
  }
}

}  // namespace im2fit
