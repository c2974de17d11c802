// SPDX-License-Identifier: Apache-2.0
// A fused portrait picture, 480x640: a person at 2.3 m, 2 mm of noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/rayform/ray_form.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {

struct FigurePicture {
  Intrinsics camera{480, 640, 575.8F, 575.8F, 239.5F, 319.5F};
  test::Figure figure = test::standing_figure(0, 2300);
  std::vector<std::uint16_t> depth_q4;
  std::vector<std::uint8_t> mask;
  int seen = 0;  // px
  RayTable rays{480, 640};
  RayForm right{480, 640}, down{480, 640}, away{480, 640};

  FigurePicture() {
    const test::FigureCloud cloud = test::render_cloud(figure, camera, 2.0, 0, 0, 7);
    for (const float z : cloud.z) {
      const bool person = !std::isnan(z);
      depth_q4.push_back(person ? static_cast<std::uint16_t>(std::lround(z * 16)) : std::uint16_t{0});
      mask.push_back(person ? 255 : 0);
    }
    seen = cloud.valid_count;
    rays.set(camera);
    right.set(rays, {1, 0, 0});
    down.set(rays, {0, 1, 0});
    away.set(rays, {0, 0, 1});
  }
  ImageView<const std::uint16_t> depths() const { return {depth_q4.data(), camera.width, camera.height}; }
  MaskView masks() const { return {mask.data(), camera.width, camera.height}; }
};

// Instructions at 4 a cycle of 2.5 GHz.
inline double instructions_us(double count) {
  return count / 1e4;
}

}  // namespace im2fit::bench
