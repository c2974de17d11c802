// SPDX-License-Identifier: Apache-2.0
#include "kernels/project/project.h"

namespace im2fit {

void project_portable(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                      std::int64_t* out) {
  for (int r = 0; r < row_count; ++r, weights += stride) {
    std::int64_t sum = 0;
    for (int i = 0; i < stride; i += 2) sum += feature[i] * weights[i] + feature[i + 1] * weights[i + 1];
    out[r] = sum;
  }
}

void project(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count, std::int64_t* out) {
  project_portable(feature, weights, stride, row_count, out);
}

}  // namespace im2fit
