// SPDX-License-Identifier: Apache-2.0
// A mean mesh that people are deformed from: what it can be pulled by (its dimensions, joints that stay, places of
// free shape), and the least-energy answer to each pull.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/rng.h"
#include "evaluation/population/body_dimensions.h"
#include "evaluation/population/deformation_graph.h"

namespace im2fit::lab {

// Free shape: pairs and single places on the skin, pushed along the normal.
inline constexpr int kPairs = 20, kSingles = 10;
// Of joints forwards or back.
inline constexpr double kPostureMm = 10;

using Basis = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Mean {
  std::vector<Vec3f> rest;
  std::unique_ptr<BodyDimensions> dimensions;
  DimensionValues own{};
  Basis basis;                  // a row a coordinate, a column a response of unit energy
  Eigen::MatrixXd products;     // of responses, by energy
  Eigen::MatrixXd stay;         // a row a joint coordinate, in tolerances: it moves by this along the responses
  int free_first = 0;           // columns that free shape is drawn of
  std::vector<double> free_mm;  // what one of the column moves its own place by, mm
};

// Fills everything but `rest`, which is set. `graph` is of that mesh and has answered nothing yet. `number`: of the
// places of free shape.
void complete_mean(Mean& mean, DimensionSurface surface, DeformationGraph& graph, std::uint64_t number);

// What the survey does not say, drawn in this order: how far the back lies behind the sides (of chest, waist and hip,
// given the depths wanted), bumps in pairs and single, joints forwards or back.
void draw_backs(const Mean& mean, Rng& rng, DimensionValues& wanted);
Eigen::VectorXd draw_free_shape(const Mean& mean, Rng& rng);
Eigen::VectorXd draw_posture(const Mean& mean, Rng& rng);

// Sum over pulls of the gradient's product with each response.
Eigen::RowVectorXd along_basis(const Basis& basis, const PullRow& row);

// The mean mesh moved by responses times `c`. `rest`: all vertices.
void deform(const Mean& mean, const Eigen::VectorXd& c, std::span<Vec3f> rest);

}  // namespace im2fit::lab
