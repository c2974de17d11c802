// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "kernels/blend/blend.h"

namespace im2fit {

void blend_portable(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into,
                    int into_count) {
  for (const BlendRun* run = runs; run != runs + run_count; ++run) {
    const std::int16_t* __restrict delta = deltas + std::size_t{run->first_delta} * 3;
    const std::size_t count = std::size_t{run->vertex_count} * 3;
    for (int m = 0; m < into_count; ++m) {
      float* __restrict value = into[m].vertices + std::size_t{run->first_vertex} * 3;
      const float scale = into[m].scale;
      for (std::size_t i = 0; i < count; ++i) value[i] += scale * static_cast<float>(delta[i]);
    }
  }
}

void blend(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into, int into_count) {
  IM2FIT_CHOSEN_ONCE best = fastest(kBlendKernels);
  best(runs, run_count, deltas, into, into_count);
}

}  // namespace im2fit
