// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void moments_ref(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums) {
  for (int degree = 0; degree <= 4; ++degree) {
    for (int j = 0; j <= degree; ++j) {
      std::int64_t sum = 0;
      for (int n = 0; n < count; ++n) {
        if (points[n].x < first_x || points[n].x > last_x) continue;
        std::int64_t term = 1;
        for (int i = 0; i < degree - j; ++i) term *= points[n].x;
        for (int i = 0; i < j; ++i) term *= points[n].y;
        sum += term;
      }
      sums[moment_index(degree - j, j)] = sum;
    }
  }
}

}  // namespace im2fit
