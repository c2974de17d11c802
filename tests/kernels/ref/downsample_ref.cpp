// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::joints {

void downsample_box_ref(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments) {
  moments = {};
  for (int v = 0; v < box.height; ++v) {
    for (int u = 0; u < box.width; ++u) {
      std::uint16_t z = 0;
      for (int y = (box.v_first + v) * box.step; y < (box.v_first + v + 1) * box.step; ++y)
        for (int x = (box.u_first + u) * box.step; x < (box.u_first + u + 1) * box.step; ++x)
          if (z == 0 && y < box.depth.height && x < box.depth.width && box.mask.at(x, y) != 0) z = box.depth.at(x, y);
      *out++ = z;
      moments.count += z != 0 ? 1 : 0;
      moments.z += z;
      moments.uz += std::int64_t{z} * u;
      moments.vz += std::int64_t{z} * v;
    }
  }
}

}  // namespace im2fit::joints
