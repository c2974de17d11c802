// SPDX-License-Identifier: Apache-2.0
// A rectangle on the floor, in which people are measured.
#pragma once

#include <cmath>

namespace im2fit {

inline constexpr float kRegionReachMaxMm = 20'000.0F;  // of a corner from the camera, along x and along z

// On the floor, x to the right as the camera sees it and z away from it; the point under the camera is (0, 0).
struct FloorRegion {
  float x0_mm = 0, z0_mm = 0, x1_mm = 0, z1_mm = 0;
  bool holds(float x_mm, float z_mm, float margin_mm = 0) const {
    return x_mm >= x0_mm - margin_mm && x_mm <= x1_mm + margin_mm && z_mm >= z0_mm - margin_mm &&
           z_mm <= z1_mm + margin_mm;
  }
};

// NaN fails.
inline bool is_region(const FloorRegion& region) {
  const auto near = [](float mm) { return std::fabs(mm) <= kRegionReachMaxMm; };
  return near(region.x0_mm) && near(region.z0_mm) && near(region.x1_mm) && near(region.z1_mm) &&
         region.x0_mm < region.x1_mm && region.z0_mm < region.z1_mm;
}

}  // namespace im2fit
