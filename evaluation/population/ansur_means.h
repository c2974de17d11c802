// SPDX-License-Identifier: Apache-2.0
// The six mean meshes that people of the family `ansur` are deformed from (ansur_people.h).
#pragma once

#include <array>
#include <cstdint>

#include "body/model.h"
#include "evaluation/population/deformable_mean.h"

namespace im2fit::lab {

// A fixed mean mesh: the build, and the changes to the model's head, hands and feet.
struct MeanBuild {
  bool woman;
  double stature_mm, weight_kg, index_most;  // body mass index up to which it serves
  float age_years, muscle, cup;
  std::array<float, 3> race;
  Vec3f head, hand, foot;  // scales along the mesh' axes
  float crown_mm, occiput_mm;
};
inline constexpr std::size_t kMeanCount = 6;
extern const std::array<MeanBuild, kMeanCount> kMeans;

struct BuiltMean {
  body::Params params;
  Mean mean;
};

// Some 0.8 s and 25 MB. `number`: of kMeans.
BuiltMean make_mean(const body::BodyModel& model, const MeanBuild& build, std::uint64_t number);

}  // namespace im2fit::lab
