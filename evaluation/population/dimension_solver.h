// SPDX-License-Identifier: Apache-2.0
// The least-energy deformation of a mean mesh that meets a person's dimensions.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>

#include "core/measurement.h"
#include "evaluation/population/deformable_mean.h"

namespace im2fit::lab {

// From `c` on, which becomes the answer, in at most so many steps. Energy is measured about `start`; joints move by
// `posture`, in tolerances. `wanted`: NaN is left free. Returns what `rest`, the deformed mesh, has.
DimensionValues solve_dimensions(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
                                 const Eigen::VectorXd& posture, int steps, Eigen::VectorXd& c,
                                 std::span<Vec3f> rest);

struct SolverSteps {
  int first, more;  // of the first round and of each later one
  int rounds;
};
// The same for the pose in which people are measured: chest and shoulders change as the arms come down from the rest
// pose. `measure`: the measurements of `rest` in that pose; called once a round, the last time for the answer.
DimensionValues solve_in_pose(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
                              const Eigen::VectorXd& posture, const SolverSteps& steps, std::span<Vec3f> rest,
                              const std::function<MeasurementValues()>& measure);

}  // namespace im2fit::lab
