// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/grid.h"

#include <algorithm>
#include <array>

namespace im2fit::segment {
namespace {

int step_for(int width, int height) {
  return std::max(1, (std::max(width, height) + 80) / 160);
}

}  // namespace

Grid::Grid(int image_width, int image_height)
    : step(step_for(image_width, image_height)),
      width(image_width / step),
      height(image_height / step),
      depth(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      height_mm(depth.size()),
      ray_x(static_cast<std::size_t>(width)),
      ray_y(static_cast<std::size_t>(height)) {}

void Grid::sample(DepthView image, const Intrinsics& k) {
  intrinsics = k;
  const float centre = 0.5F * static_cast<float>(step - 1);
  for (int c = 0; c < width; ++c)
    ray_x[static_cast<std::size_t>(c)] = (static_cast<float>(c * step) + centre - k.cx) / k.fx;
  for (int r = 0; r < height; ++r)
    ray_y[static_cast<std::size_t>(r)] = (static_cast<float>(r * step) + centre - k.cy) / k.fy;

  // Corners and one inner pixel: five looks at different projector dots, for one median.
  const int last = step - 1;
  const std::array<int, 5> du = {0, last, step / 2, 0, last};
  const std::array<int, 5> dv = {0, 0, step / 2, last, last};
  const int look_count = step == 1 ? 1 : 5;
  valid_count = 0;
  for (int r = 0; r < height; ++r) {
    for (int c = 0; c < width; ++c) {
      std::array<std::uint16_t, 5> seen{};
      int count = 0;
      for (int i = 0; i < look_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const std::uint16_t z = image.at(c * step + du[at], r * step + dv[at]);
        if (z == 0 || z > kDepthMaxMm) continue;
        int place = count++;
        for (; place > 0 && seen[static_cast<std::size_t>(place - 1)] > z; --place)
          seen[static_cast<std::size_t>(place)] = seen[static_cast<std::size_t>(place - 1)];
        seen[static_cast<std::size_t>(place)] = z;
      }
      const bool valid = count > 0;
      depth[static_cast<std::size_t>(index(c, r))] =
          valid ? seen[static_cast<std::size_t>((count - 1) / 2)] : std::uint16_t{0};
      valid_count += valid ? 1 : 0;
    }
  }
}

void Grid::measure_heights(const FloorPlane& floor) {
  const Vec3f up = floor.known ? floor.up : Vec3f{0, -1, 0};
  const float camera = floor.known ? floor.camera_height_mm : 0.0F;
  for (int r = 0; r < height; ++r) {
    const float row = up.y * ray_y[static_cast<std::size_t>(r)] + up.z;
    for (int c = 0; c < width; ++c) {
      const auto i = static_cast<std::size_t>(index(c, r));
      height_mm[i] = (up.x * ray_x[static_cast<std::size_t>(c)] + row) * static_cast<float>(depth[i]) + camera;
    }
  }
}

}  // namespace im2fit::segment
