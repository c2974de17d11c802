// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/grid.h"

#include <algorithm>

#include "kernels/sample/sample.h"

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
      ray_x(at(width)),
      ray_y(at(height)) {}

void Grid::sample(DepthView image, const Intrinsics& k) {
  intrinsics = k;
  const float centre = 0.5F * static_cast<float>(step - 1);
  for (int c = 0; c < width; ++c) ray_x[at(c)] = (static_cast<float>(c * step) + centre - k.cx) / k.fx;
  for (int r = 0; r < height; ++r) ray_y[at(r)] = (static_cast<float>(r * step) + centre - k.cy) / k.fy;

  im2fit::sample(image, step, depth.data());
  valid_count = 0;
  for (const std::uint16_t z : depth) valid_count += z != 0 ? 1 : 0;
}

void Grid::measure_heights(const FloorPlane& floor) {
  const Vec3f up = floor.up;
  const float camera = floor.known ? floor.camera_height_mm : 0.0F;
  for (int r = 0; r < height; ++r) {
    const float row = up.y * ray_y[at(r)] + up.z;
    for (int c = 0; c < width; ++c) {
      const auto i = at(index(c, r));
      height_mm[i] = (up.x * ray_x[at(c)] + row) * static_cast<float>(depth[i]) + camera;
    }
  }
}

}  // namespace im2fit::segment
