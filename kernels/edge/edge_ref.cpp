// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kernels/edge/edge.h"

namespace im2fit {

void edge_ref(DepthView depth, MaskImage mask) {
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const double z = depth.at(u, v);
      const double limit = 40 + std::floor(std::floor(z * z / 65536) * 18361 / 65536);
      bool jump = false, alone = true;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          if ((du == 0 && dv == 0) || u + du < 0 || v + dv < 0 || u + du >= depth.width || v + dv >= depth.height)
            continue;
          const double other = depth.at(u + du, v + dv);
          if (other == 0) continue;
          const bool far = std::fabs(other - z) > limit;
          jump = jump || (far && (du == 0 || dv == 0));
          alone = alone && far;
        }
      }
      mask.at(u, v) = z != 0 && (jump || alone) ? 255 : 0;
    }
  }
}

}  // namespace im2fit
