// SPDX-License-Identifier: Apache-2.0
// How cloth hangs and folds.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/rng.h"
#include "core/vec3.h"

namespace im2fit::lab {

// Cloth on a posed body, in the axes of body::skin().
struct DrapedCloth {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;  // seen from both sides
};

// Sum of plane waves: folds run across their wave vectors.
class Folds {
 public:
  // Wavelengths in mm; `stretch` times longer along `grain` (a unit vector).
  Folds(Rng& rng, double shortest, double longest, Vec3f grain, float stretch);
  float at(Vec3f p) const;  // mean 0, about -1..1

 private:
  struct Wave {
    Vec3f k;
    float phase = 0;
  };
  std::array<Wave, 4> waves_;
};

// A shirt's radius about the trunk's upright axis: it spans the hollows of every level and hangs from the protruding
// parts above.
class TrunkHang {
 public:
  // `up`: 0 at the hips, 1 at the shoulders; counts from kLowest up.
  void add(float up, float angle, float radius_mm);
  // Below `chest` (up) the cloth falls inwards by at most `slack_mm` a level.
  void hang(float chest, float slack_mm);
  float at(float up, float angle) const;  // after hang()

 private:
  static constexpr int kLevels = 40, kSectors = 36;
  static constexpr float kLowest = -0.35F;
  static float level_of(float up) { return (up - kLowest) / (1.05F - kLowest) * kLevels; }
  using Ring = std::array<float, kSectors>;
  std::array<Ring, kLevels> radius_{};
};

}  // namespace im2fit::lab
