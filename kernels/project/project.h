// SPDX-License-Identifier: Apache-2.0
// A standardised feature times a matrix of 16-bit weights, exactly: the sums behind a feature's codes.
#pragma once

#include <cstdint>

#include "kernels/standardise/standardise.h"
#include "kernels/tier.h"

namespace im2fit {

// Rows are padded with zeros to a multiple of this, so that no variant has a rest to do.
inline constexpr int kProjectBlock = 16;
constexpr int projected_stride(int feature_size) {
  return (feature_size + kProjectBlock - 1) / kProjectBlock * kProjectBlock;
}

// out[r] = sum over i < stride of feature[i] * weights[r * stride + i]. stride: a multiple of kProjectBlock; feature:
// within +-kStandardFeatureRawMax, weights: any but -32768. Integers, so exact in any order: two products add up to
// less than 2 * 20480 * 32767 < 2^31 before they are widened. At most 2^18 features. No allocation, thread-safe.
using ProjectFunction = void(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                             std::int64_t* out);
ProjectFunction project_portable, project;

inline constexpr KernelVariant<ProjectFunction> kProjectKernels[] = {IM2FIT_PORTABLE(project)};

}  // namespace im2fit
