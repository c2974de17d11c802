// SPDX-License-Identifier: Apache-2.0
// The shape space of the training population: workstation side of body/fit.
#pragma once

#include <cstdint>

#include "body/shape_space.h"

namespace im2fit::lab {

struct ShapeSpaceOptions {
  // A third of them out of distribution in the trunk, a third all over (train/population/ood_subjects.h): more kinds
  // of difference than the index has.
  int people = 1800;
  int points = 2400;
  int shapes = 64;
  std::uint64_t seed = 0x5A4E;
  int threads = 2;  // does not change the result
};

body::ShapeSpace build_shape_space(const body::BodyModel& model, const ShapeSpaceOptions& options);

}  // namespace im2fit::lab
