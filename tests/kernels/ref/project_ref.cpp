// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void project_ref(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                 std::int64_t* out) {
  for (int r = 0; r < row_count; ++r) {
    // Whole numbers below 2^53 for up to 2^25 features: exact.
    double sum = 0;
    for (int i = 0; i < stride; ++i)
      sum += static_cast<double>(feature[i]) * static_cast<double>(weights[std::int64_t{r} * stride + i]);
    out[r] = static_cast<std::int64_t>(sum);
  }
}

}  // namespace im2fit
