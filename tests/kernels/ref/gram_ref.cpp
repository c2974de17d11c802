// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

// X' W X in long double.
void add_gram_ref(const double* rows, const double* weights, int count, int used, double* sums, double* products) {
  using Wide = long double;
  for (int i = 0; i < used; ++i) {
    Wide sum = 0;
    for (int n = 0; n < count; ++n) sum += Wide{weights[n]} * Wide{rows[n * kGramWidth + i]};
    sums[i] += static_cast<double>(sum);
    for (int j = 0; j <= i; ++j) {
      Wide product = 0;
      for (int n = 0; n < count; ++n)
        product += Wide{weights[n]} * Wide{rows[n * kGramWidth + i]} * Wide{rows[n * kGramWidth + j]};
      products[i * kGramWidth + j] += static_cast<double>(product);
    }
  }
}

}  // namespace im2fit
