// SPDX-License-Identifier: Apache-2.0
// The room that whole frames are of, and the files that whole frames need.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/rng.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {

inline constexpr Intrinsics kCamera = {480, 640, 575.8F, 575.8F, 239.5F, 319.5F};
inline constexpr float kDistanceMm = 2300;
inline constexpr double kFloorMm = 900, kWallMm = 3900;  // the figure's soles, and a wall behind it

// The file a variable names, else the cache's.
inline std::string file_of(const char* variable, const char* name, const char* folder = "small/") {
  if (const char* path = std::getenv(variable)) return path;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  return (cache != nullptr ? std::string(cache) : std::string(home != nullptr ? home : "") + "/.cache") + "/im2fit/" +
         folder + name;
}

// A Kinect's picture of figures in a room: disparity in steps of 1/8 pixel, half a step of noise.
inline std::vector<std::uint16_t> picture(const std::vector<test::Figure>& figures, const Intrinsics& k,
                                          double wall_mm, std::uint64_t seed) {
  constexpr double kStep = 2.85e-6;  // 1/mm
  Rng rng(seed);
  std::vector<std::uint16_t> depth;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const double tx = (u - double{k.cx}) / double{k.fx};
      const double ty = (v - double{k.cy}) / double{k.fy};
      test::Hit hit{wall_mm, {0, 0, -1}};
      for (const test::Figure& figure : figures) hit = test::nearer(figure.cast_ray(tx, ty), hit);
      if (ty > 0) hit = test::nearer(hit, {kFloorMm / ty, {0, -1, 0}});
      const double steps = std::floor(1.0 / hit.z / kStep + 0.5 * double{rng.fast_normal()} + 0.5);
      depth.push_back(static_cast<std::uint16_t>(std::lround(1.0 / (kStep * steps))));
    }
  }
  return depth;
}
inline std::vector<std::uint16_t> picture(const test::Figure& figure, std::uint64_t seed) {
  return picture({figure}, kCamera, kWallMm, seed);
}

}  // namespace im2fit::bench
