// SPDX-License-Identifier: Apache-2.0
#include "kernels/gram/gram.h"

namespace im2fit {

void add_gram_portable(const double* rows, const double* weights, int count, int used, double* sums,
                       double* products) {
  for (int n = 0; n < count; ++n, rows += kGramWidth) {
    const double* __restrict x = rows;
    for (int j = 0; j < kGramWidth; ++j) sums[j] += weights[n] * x[j];
    for (int i = 0; i < used; ++i) {
      double* __restrict product = products + i * kGramWidth;
      const double wx = weights[n] * x[i];
      const int last = i | 3;  // whole vectors
      for (int j = 0; j <= last; ++j) product[j] += wx * x[j];
    }
  }
}

void add_gram(const double* rows, const double* weights, int count, int used, double* sums, double* products) {
  add_gram_portable(rows, weights, count, used, sums, products);
}

}  // namespace im2fit
