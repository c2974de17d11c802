// SPDX-License-Identifier: Apache-2.0
// The six mean meshes that people of the family `ansur` are deformed from (ansur_people.h), and what each can be
// pulled by: its dimensions, joints that stay, places of free shape.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/model.h"
#include "evaluation/population/body_dimensions.h"
#include "evaluation/population/deformation_graph.h"

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

// Free shape: pairs and single places on the skin, pushed along the normal.
inline constexpr int kPairs = 20, kSingles = 10;
// Of joints forwards or back.
inline constexpr double kPostureMm = 10;

using Basis = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Mean {
  body::Params params;
  std::vector<Vec3f> rest;
  std::unique_ptr<BodyDimensions> dimensions;
  DimensionValues own{};
  Basis basis;                  // a row a coordinate, a column a response of unit energy
  Eigen::MatrixXd products;     // of responses, by energy
  Eigen::MatrixXd stay;         // a row a joint coordinate, in tolerances: it moves by this along the responses
  int free_first = 0;           // columns that free shape is drawn of
  std::vector<double> free_mm;  // what one of the column moves its own place by, mm
};

// Some 0.8 s and 25 MB. `number`: of kMeans.
Mean make_mean(const body::BodyModel& model, const MeanBuild& build, std::uint64_t number);

// Sum over pulls of the gradient's product with each response.
Eigen::RowVectorXd along_basis(const Basis& basis, const PullRow& row);

// The mean mesh moved by responses times `c`. `rest`: all vertices.
void deform(const Mean& mean, const Eigen::VectorXd& c, std::span<Vec3f> rest);

}  // namespace im2fit::lab
