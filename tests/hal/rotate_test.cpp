// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hal/source.h"
#include "support.h"

namespace im2fit::hal {
namespace {

// Of any size, in images with more in a row than the picture.
TEST(Rotate, PutsEveryPixelInItsPlace) {
  constexpr int kMore = 3;
  constexpr std::uint16_t kOutside = 12345;
  for (const int width : {1, 7, 8, 17, 33, 72})
    for (const int height : {1, 6, 8, 25, 40}) {
      const Picture in = random_picture(width + kMore, height, static_cast<std::uint64_t>(100 * width + height));
      const DepthView view(in.pixels.data(), width, height, width + kMore);
      for (const int rotate_deg : {0, 90, 180, 270}) {
        const bool quarter = rotate_deg % 180 != 0;
        const int w = quarter ? height : width, h = quarter ? width : height;
        Picture out(w + kMore, h);
        out.pixels.assign(out.pixels.size(), kOutside);
        rotate_upright(view, rotate_deg, DepthImage(out.pixels.data(), w, h, w + kMore));
        for (int v = 0; v < h; ++v) {
          for (int u = 0; u < w; ++u) {
            const int x = rotate_deg == 0 ? u : rotate_deg == 90 ? v : rotate_deg == 180 ? w - 1 - u : h - 1 - v;
            const int y = rotate_deg == 0 ? v : rotate_deg == 90 ? w - 1 - u : rotate_deg == 180 ? h - 1 - v : u;
            ASSERT_EQ(out.image().at(u, v), view.at(x, y)) << width << 'x' << height << ' ' << rotate_deg;
          }
          for (int u = w; u < w + kMore; ++u) ASSERT_EQ(out.image().at(u, v), kOutside);
        }
      }
    }
}

}  // namespace
}  // namespace im2fit::hal
