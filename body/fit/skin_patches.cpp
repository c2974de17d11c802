// SPDX-License-Identifier: Apache-2.0
#include "body/fit/skin_patches.h"

#include "core/vec3.h"

namespace im2fit::body {

std::vector<std::uint16_t> skin_patches(const ShapeSpace& space) {
  const auto middle = [&](std::size_t i) {
    const float* at = space.point_mean.data() + i * kPointValues;
    return Vec3f{at[0], at[1], at[2]};
  };
  std::vector<std::uint16_t> patch(space.point_count);
  std::vector<float> away(space.point_count, 1e30F);  // squared, from the nearest centre so far
  std::size_t centre = 0;
  for (std::size_t p = 0; p < patch_count(space); ++p) {
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < space.point_count; ++i) {
      const Vec3f d = middle(i) - middle(centre);
      const float square = dot(d, d);
      if (square < away[i]) {
        away[i] = square;
        patch[i] = static_cast<std::uint16_t>(p);
      }
      if (away[i] > away[farthest]) farthest = i;
    }
    centre = farthest;
  }
  return patch;
}

}  // namespace im2fit::body
