// SPDX-License-Identifier: Apache-2.0
#include "kernels/standardise/standardise_one.h"

namespace im2fit {

void standardise_portable(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  for (int i = 0; i < count; ++i) out[i] = standardise_one(feature[i], mean[i], scale[i]);
}

void standardise(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kStandardiseKernels);
  best(feature, mean, scale, count, out);
}

}  // namespace im2fit
