// SPDX-License-Identifier: Apache-2.0
#include "kernels/normals/normals.h"

namespace im2fit {

void normals(const Intrinsics& intrinsics, const float* x, const float* y, const float* z, int radius_px,
             float max_step_mm, float* nx, float* ny, float* nz) {
  IM2FIT_CHOSEN_ONCE best = fastest(kNormalsKernels);
  best(intrinsics, x, y, z, radius_px, max_step_mm, nx, ny, nz);
}

}  // namespace im2fit
