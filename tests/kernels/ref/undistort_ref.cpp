// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void undistort_ref(const std::uint16_t* in, int, const UndistortRun* runs, int run_count, std::uint16_t* out) {
  for (int i = 0; i < run_count; ++i)
    for (std::int32_t k = 0; k < runs[i].count; ++k)
      out[runs[i].to + k] = runs[i].from < 0 ? std::uint16_t{0} : in[runs[i].from + k];
}

}  // namespace im2fit
