// SPDX-License-Identifier: Apache-2.0
#include "body/fit/skin_patches.h"

#include <algorithm>

#include "core/vec3.h"

namespace im2fit::body {
namespace {

using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));
constexpr float kFar = 1e30F;

// Of the lanes of no point none is far from anything.
struct FourPoints {
  Floats x = {}, y = {}, z = {};
  Floats away = {};  // squared, from the nearest centre so far
  Ints patch = {};
};

}  // namespace

std::vector<std::uint16_t> skin_patches(const ShapeSpace& space) {
  std::vector<FourPoints> all((space.point_count + 3) / 4);
  for (std::size_t i = 0; i < space.point_count; ++i) {
    const float* at = space.point_mean.data() + i * kPointValues;
    FourPoints& four = all[i / 4];
    four.x[i % 4] = at[0];
    four.y[i % 4] = at[1];
    four.z[i % 4] = at[2];
    four.away[i % 4] = kFar;
  }
  const auto point = [&](std::size_t i) {
    return Vec3f{all[i / 4].x[i % 4], all[i / 4].y[i % 4], all[i / 4].z[i % 4]};
  };
  std::size_t centre = 0;
  for (std::size_t p = 0; p < patch_count(space); ++p) {
    const Vec3f c = point(centre);
    Floats most = {};
    for (FourPoints& four : all) {
      const Floats dx = four.x - c.x, dy = four.y - c.y, dz = four.z - c.z;
      const Floats square = dx * dx + dy * dy + dz * dz;
      const Ints nearer = square < four.away;
      four.patch = nearer ? Ints{} + static_cast<int>(p) : four.patch;
      four.away = nearer ? square : four.away;
      most = four.away > most ? four.away : most;
    }
    const float farthest = std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
    centre = 0;
    while (all[centre / 4].away[centre % 4] < farthest) ++centre;
  }
  std::vector<std::uint16_t> patch(space.point_count);
  for (std::size_t i = 0; i < patch.size(); ++i) patch[i] = static_cast<std::uint16_t>(all[i / 4].patch[i % 4]);
  return patch;
}

}  // namespace im2fit::body
