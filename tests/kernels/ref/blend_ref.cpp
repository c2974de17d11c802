// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void blend_ref(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into,
               int into_count) {
  for (int m = 0; m < into_count; ++m) {
    for (const BlendRun* run = runs; run != runs + run_count; ++run) {
      for (std::size_t i = 0; i < 3U * run->vertex_count; ++i) {
        float& value = into[m].vertices[std::size_t{run->first_vertex} * 3 + i];
        const double delta = deltas[std::size_t{run->first_delta} * 3 + i];
        value = static_cast<float>(double{value} + double{into[m].scale} * delta);
      }
    }
  }
}

}  // namespace im2fit
