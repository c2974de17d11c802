// SPDX-License-Identifier: Apache-2.0
// Weighted products of the columns of a narrow matrix: the normal equations of a local regression.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kGramWidth = 16;  // columns, unused ones 0

// sums[j] += w x[j] and products[16 i + j] += (w x[i]) x[j] for j <= i < used, row by row, each step rounded to
// double. rows: 16 values each; `used`: columns at work, 0..16. Products right of the diagonal may be written with
// anything. Portable is within count * 2^-52 of the sum of the terms' magnitudes of ref. No
// allocation, thread-safe.
using AddGramFunction = void(const double* rows, const double* weights, int count, int used, double* sums,
                             double* products);
AddGramFunction add_gram_portable, add_gram;

inline constexpr KernelVariant<AddGramFunction> kAddGramKernels[] = {IM2FIT_PORTABLE(add_gram)};

}  // namespace im2fit
