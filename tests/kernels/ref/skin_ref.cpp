// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

// v' = sum_s w_s (R_s v + t_s) (Magnenat-Thalmann et al. 1988).
void skin_ref(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
              float* out) {
  for (int v = 0; v < vertex_count; ++v) {
    const float* p = vertices + 3 * v;
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0;
      for (std::size_t i = 0; i < 4 && (i == 0 || records[v].weight[i] > 0); ++i) {
        const SkinMatrix& m = matrices[records[v].segment[i]];
        double moved = double{m.column[3][axis]};
        for (int j = 0; j < 3; ++j) moved += double{m.column[j][axis]} * double{p[j]};
        sum += moved * double{records[v].weight[i]};
      }
      out[3 * v + axis] = static_cast<float>(sum);
    }
  }
}

}  // namespace im2fit
