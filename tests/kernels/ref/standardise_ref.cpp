// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void standardise_ref(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  constexpr double kMax = kStandardFeatureMax;
  for (int i = 0; i < count; ++i) {
    const double z = (double{feature[i]} - double{mean[i]}) * double{scale[i]};
    out[i] = static_cast<std::int16_t>(std::isnan(z) ? 0 : std::lround(4096 * std::clamp(z, -kMax, kMax)));
  }
}

}  // namespace im2fit
