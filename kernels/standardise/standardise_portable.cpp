// SPDX-License-Identifier: Apache-2.0
#include "kernels/standardise/standardise.h"

namespace im2fit {
namespace {

std::int16_t standardise_one(float feature, float mean, float scale) {
  float z = (feature - mean) * scale;
  if (z != z) z = 0;  // not measured, or infinite where scale is 0
  z = z > kStandardFeatureMax ? kStandardFeatureMax : z;
  z = z < -kStandardFeatureMax ? -kStandardFeatureMax : z;
  // Adding 1.5 * 2^23 leaves no fraction bits: the sum is rounded to a whole number, ties to even.
  constexpr float kWhole = 12582912.0F;
  return static_cast<std::int16_t>((z * 4096.0F + kWhole) - kWhole);
}

}  // namespace

void standardise_portable(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  for (int i = 0; i < count; ++i) out[i] = standardise_one(feature[i], mean[i], scale[i]);
}

void standardise(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  standardise_portable(feature, mean, scale, count, out);
}

}  // namespace im2fit
