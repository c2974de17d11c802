// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/gram/gram.h"

// ARMv7 has no vectors of doubles.
#ifdef __aarch64__
namespace im2fit {
namespace {

// Two rows of the result from row `first`, kVectors times two columns: all sums in registers.
template <int kVectors>
inline void add_block(const double* rows, const double* weights, int count, int first, double* products) {
  double* out = products + first * kGramWidth;
  float64x2_t upper[kVectors], lower[kVectors];
  for (int k = 0; k < kVectors; ++k) {
    upper[k] = vld1q_f64(out + 2 * k);
    lower[k] = vld1q_f64(out + kGramWidth + 2 * k);
  }
  for (int n = 0; n < count; ++n, rows += kGramWidth) {
    const float64x2_t wx = vmulq_n_f64(vld1q_f64(rows + first), weights[n]);
    for (int k = 0; k < kVectors; ++k) {
      const float64x2_t x = vld1q_f64(rows + 2 * k);
      upper[k] = vaddq_f64(upper[k], vmulq_laneq_f64(x, wx, 0));
      lower[k] = vaddq_f64(lower[k], vmulq_laneq_f64(x, wx, 1));
    }
  }
  for (int k = 0; k < kVectors; ++k) {
    vst1q_f64(out + 2 * k, upper[k]);
    vst1q_f64(out + kGramWidth + 2 * k, lower[k]);
  }
}

}  // namespace

void add_gram_neon(const double* rows, const double* weights, int count, int used, double* sums, double* products) {
  float64x2_t sum[8];
  for (int k = 0; k < 8; ++k) sum[k] = vld1q_f64(sums + 2 * k);
  for (int n = 0; n < count; ++n)
    for (int k = 0; k < 8; ++k)
      sum[k] = vaddq_f64(sum[k], vmulq_n_f64(vld1q_f64(rows + n * kGramWidth + 2 * k), weights[n]));
  for (int k = 0; k < 8; ++k) vst1q_f64(sums + 2 * k, sum[k]);
  if (used > 0) add_block<1>(rows, weights, count, 0, products);
  if (used > 2) add_block<2>(rows, weights, count, 2, products);
  if (used > 4) add_block<3>(rows, weights, count, 4, products);
  if (used > 6) add_block<4>(rows, weights, count, 6, products);
  if (used > 8) add_block<5>(rows, weights, count, 8, products);
  if (used > 10) add_block<6>(rows, weights, count, 10, products);
  if (used > 12) add_block<7>(rows, weights, count, 12, products);
  if (used > 14) add_block<8>(rows, weights, count, 14, products);
}

}  // namespace im2fit
#endif
