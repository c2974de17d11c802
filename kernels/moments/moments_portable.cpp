// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "kernels/moments/moments.h"

namespace im2fit {

void moments_portable(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums) {
  std::int64_t s[kMomentCount] = {};
  for (int n = 0; n < count; ++n) {
    const std::int32_t x = points[n].x, y = points[n].y;
    if (x < first_x || x > last_x) continue;
    // Squares below 2^24: products of two of them need 64 bits.
    const std::int64_t xx = x * x, xy = x * y, yy = y * y;
    s[0] += 1;
    s[1] += x, s[2] += y;
    s[3] += xx, s[4] += xy, s[5] += yy;
    s[6] += xx * x, s[7] += xx * y, s[8] += yy * x, s[9] += yy * y;
    s[10] += xx * xx, s[11] += xx * xy, s[12] += xx * yy, s[13] += xy * yy, s[14] += yy * yy;
  }
  std::memcpy(sums, s, sizeof s);
}

void moments(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums) {
  moments_portable(points, count, first_x, last_x, sums);
}

}  // namespace im2fit
