// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/gram/gram.h"

namespace im2fit {
namespace {

// kRows rows of the result from row `first`, kVectors times four columns: all sums in registers.
template <int kRows, int kVectors>
inline void add_block(const double* rows, const double* weights, int count, int first, double* products) {
  double* out = products + first * kGramWidth;
  __m256d sum[kRows][kVectors];
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kVectors; ++k) sum[r][k] = _mm256_loadu_pd(out + r * kGramWidth + 4 * k);
  for (int n = 0; n < count; ++n, rows += kGramWidth) {
    const __m256d weight = _mm256_broadcast_sd(weights + n);
    __m256d x[kVectors];
    for (int k = 0; k < kVectors; ++k) x[k] = _mm256_loadu_pd(rows + 4 * k);
    for (int r = 0; r < kRows; ++r) {
      const __m256d wx = _mm256_mul_pd(weight, _mm256_broadcast_sd(rows + first + r));
      for (int k = 0; k < kVectors; ++k) sum[r][k] = _mm256_add_pd(sum[r][k], _mm256_mul_pd(wx, x[k]));
    }
  }
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kVectors; ++k) _mm256_storeu_pd(out + r * kGramWidth + 4 * k, sum[r][k]);
}

}  // namespace

void add_gram_avx2(const double* rows, const double* weights, int count, int used, double* sums, double* products) {
  __m256d sum[4];
  for (int k = 0; k < 4; ++k) sum[k] = _mm256_loadu_pd(sums + 4 * k);
  for (int n = 0; n < count; ++n) {
    const __m256d weight = _mm256_broadcast_sd(weights + n);
    for (int k = 0; k < 4; ++k)
      sum[k] = _mm256_add_pd(sum[k], _mm256_mul_pd(weight, _mm256_loadu_pd(rows + n * kGramWidth + 4 * k)));
  }
  for (int k = 0; k < 4; ++k) _mm256_storeu_pd(sums + 4 * k, sum[k]);
  if (used > 0) add_block<4, 1>(rows, weights, count, 0, products);
  if (used > 4) add_block<4, 2>(rows, weights, count, 4, products);
  if (used > 8) add_block<2, 3>(rows, weights, count, 8, products);
  if (used > 10) add_block<2, 3>(rows, weights, count, 10, products);
  if (used > 12) add_block<2, 4>(rows, weights, count, 12, products);
  if (used > 14) add_block<2, 4>(rows, weights, count, 14, products);
}

}  // namespace im2fit
