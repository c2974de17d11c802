// SPDX-License-Identifier: Apache-2.0
// The least-energy deformation of a mean mesh that meets a person's dimensions.
#pragma once

#include <Eigen/Core>
#include <span>

#include "evaluation/population/deformable_mean.h"

namespace im2fit::lab {

// From `c` on, which becomes the answer, in at most so many steps. Energy is measured about `start`; joints move by
// `posture`, in tolerances. `wanted`: NaN is left free. Returns what `rest`, the deformed mesh, has.
DimensionValues solve_dimensions(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
                                 const Eigen::VectorXd& posture, int steps, Eigen::VectorXd& c,
                                 std::span<Vec3f> rest);

}  // namespace im2fit::lab
