// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kernels/standardise/standardise.h"

namespace im2fit {
namespace {

inline std::int16_t standardise_one(float feature, float mean, float scale) {
  float z = (feature - mean) * scale;
  if (z != z) z = 0;  // not measured, or infinite where scale is 0
  z = z > kStandardFeatureMax ? kStandardFeatureMax : z;
  z = z < -kStandardFeatureMax ? -kStandardFeatureMax : z;
  // Adding 1.5 * 2^23 leaves no fraction bits: the sum is rounded to a whole number, ties to even.
  constexpr float kWhole = 12582912.0F;
  return static_cast<std::int16_t>((z * 4096.0F + kWhole) - kWhole);
}

}  // namespace
}  // namespace im2fit
