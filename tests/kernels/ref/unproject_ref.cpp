// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <limits>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

// The pinhole: x = (u - cx) z / fx, y = (v - cy) z / fy.
void unproject_ref(DepthView depth, int fraction_bits, const RayTable& rays, float* x, float* y, float* z) {
  const Intrinsics& k = rays.intrinsics();
  std::size_t i = 0;
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u, ++i) {
      const double mm = depth.at(u, v) / static_cast<double>(1 << fraction_bits);
      const bool none = mm == 0;
      x[i] =
          none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>((u - double{k.cx}) * mm / double{k.fx});
      y[i] =
          none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>((v - double{k.cy}) * mm / double{k.fy});
      z[i] = none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(mm);
    }
  }
}

}  // namespace im2fit
