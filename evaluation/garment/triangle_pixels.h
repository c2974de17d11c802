// SPDX-License-Identifier: Apache-2.0
// Which pixels a triangle covers: of pictures in which things are counted, without light and colours.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/vec3.h"

namespace im2fit::lab {

// Twice the area, in pixels: less than 0 where the corners go anticlockwise for the viewer, because y goes down.
inline float doubled_area_px(Vec3f a, Vec3f b, Vec3f c) {
  return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
}

// Calls draw(index, z) for each pixel whose middle the triangle covers, row by row. Corners: x and y in pixels, and
// towards the viewer.
template <class Draw>
void for_each_pixel(int width, int height, Vec3f a, Vec3f b, Vec3f c, Draw draw) {
  const float area = doubled_area_px(a, b, c);
  if (area == 0) return;
  const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
  const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
  const int x0 = std::max(0, static_cast<int>(std::ceil(x_low - 0.5F)));
  const int x1 = std::min(width - 1, static_cast<int>(std::floor(x_high - 0.5F)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(y_low - 0.5F)));
  const int y1 = std::min(height - 1, static_cast<int>(std::floor(y_high - 0.5F)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const float px = static_cast<float>(x) + 0.5F, py = static_cast<float>(y) + 0.5F;
      const float s = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
      const float t = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
      if (s < 0 || t < 0 || s + t > 1) continue;
      draw(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x),
           a.z + s * (b.z - a.z) + t * (c.z - a.z));
    }
}

}  // namespace im2fit::lab
