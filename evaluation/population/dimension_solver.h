// SPDX-License-Identifier: Apache-2.0
// The least-energy deformation of a mean mesh that meets a person's dimensions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>

#include "evaluation/population/deformable_mean.h"

namespace im2fit::lab {

// What a dimension is called in tables, and how far off a body may be (1 SD; what is left goes to the energy).
struct DimensionInfo {
  std::string_view name;
  double tolerance;  // mm; kg
};
const std::array<DimensionInfo, kSurveyDimensionCount>& dimension_table();

// From `c` on, which becomes the answer, in at most so many steps. Energy is measured about `start`; joints move by
// `posture`, in tolerances. `wanted`: NaN is left free. Returns what `rest`, the deformed mesh, has.
DimensionValues solve_dimensions(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
                                 const Eigen::VectorXd& posture, int steps, Eigen::VectorXd& c,
                                 std::span<Vec3f> rest);

}  // namespace im2fit::lab
