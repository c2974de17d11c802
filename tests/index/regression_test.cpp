// SPDX-License-Identifier: Apache-2.0
#include "index/regression.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "core/rng.h"
#include "train/index/tree_packing.h"

namespace im2fit::index {
namespace {

// The bound of regression.h: half a weight's step for every feature.
TEST(Regressor, StaysCloseToTheSumInDouble) {
  Rng rng(1);
  constexpr std::size_t kFeatures = 501, kTargets = 14;
  std::vector<float> weights, bias;
  for (std::size_t t = 0; t < kTargets; ++t) {
    bias.push_back(static_cast<float>(rng.normal(0, 1)));
    // Rows of very different size, one of zeros.
    const double size = t == 3 ? 0 : std::pow(10.0, static_cast<double>(t) - 6);
    for (std::size_t i = 0; i < kFeatures; ++i) weights.push_back(static_cast<float>(size * rng.normal(0, 1)));
  }
  const RoundedWeights rounded = round_weights(weights, kFeatures);
  const Regressor regressor(rounded.weights, rounded.unit, bias);
  std::vector<std::int16_t> feature(regressor.padded_size());
  double reach = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) {
    feature[i] = static_cast<std::int16_t>(rng.index(2 * kStandardFeatureRawMax + 1) - kStandardFeatureRawMax);
    reach += std::abs(feature[i] / 4096.0);
  }
  const Targets found = regressor(feature);
  for (std::size_t t = 0; t < kTargets; ++t) {
    double sum = static_cast<double>(bias[t]), largest = 0;
    for (std::size_t i = 0; i < kFeatures; ++i) {
      const auto w = static_cast<double>(weights[t * kFeatures + i]);
      sum += w * feature[i] / 4096.0;
      largest = std::max(largest, std::abs(w));
    }
    EXPECT_NEAR(found[t], sum, largest / 65534 * reach + 1e-12 * std::abs(sum)) << "target " << t;
  }
}

struct World {
  static constexpr int kDimensions = 5, kTargets = 4;
  static constexpr std::size_t kPoints = 300;
  std::vector<std::int8_t> codes = std::vector<std::int8_t>(kPoints * kDimensions);
  std::vector<int> steps_off;  // kDimensions a point
  std::vector<std::uint8_t> residuals = std::vector<std::uint8_t>(kPoints * residual_bytes(kDimensions));
  std::vector<float> scale = {0.5F, 0.01F, 2, 1, 0.25F};
  std::vector<float> map;
  Coordinates query{};
  PackedTree packed;
  CodeTree tree;
  LocalData data;
  std::vector<Neighbour> neighbours;

  explicit World(std::uint64_t seed) {
    Rng rng(seed);
    Coordinates steps{};
    for (std::size_t j = 0; j < kDimensions; ++j) {
      steps[j] = 10 + rng.index(90);
      query[j] = rng.index(4000) - 2000;
    }
    for (auto& c : codes) c = static_cast<std::int8_t>(rng.index(256) - 128);
    for (std::size_t i = 0; i < kPoints; ++i)
      for (std::size_t j = 0; j < kDimensions; ++j) {
        steps_off.push_back(rng.index(2 * kResidualMax + 1) - kResidualMax);
        auto& pair = residuals[i * residual_bytes(kDimensions) + j / 2];
        pair = static_cast<std::uint8_t>(pair | (steps_off.back() + 8) << (j % 2 * 4));
      }
    for (int i = 0; i < kTargets * kDimensions; ++i) map.push_back(static_cast<float>(rng.normal()));
    packed = pack_tree(codes, kDimensions, steps);
    tree = packed.view();
    neighbours.resize(120);
    CodeSearch search(tree);
    const auto found = search.nearest(query, 120);
    std::copy(found.begin(), found.end(), neighbours.begin());
    data = {&tree, residuals, scale, map, kTargets};
  }
};

// As in a textbook: minimise sum w (r - b0 - b x)^2 + penalties by the normal equations, one column at a time.
Targets by_normal_equations(const World& w, const LocalOptions& options, Targets& spread) {
  const int order = options.method == LocalMethod::linear ? World::kDimensions + 1 : 1;
  const auto n = static_cast<Eigen::Index>(w.neighbours.size());
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(n, order), r(n, World::kTargets);
  Eigen::VectorXd weight(n);
  const double radius2 = static_cast<double>(w.neighbours.back().distance) + 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Neighbour& point = w.neighbours[static_cast<std::size_t>(i)];
    weight[i] = std::pow(1 - static_cast<double>(point.distance) / radius2, 2);
    for (int d = 1; d < order; ++d) {
      const auto j = static_cast<std::size_t>(d - 1);
      const int code = w.codes[w.packed.order[point.index] * World::kDimensions + j];
      x(i, d) = (code * w.tree.steps[j] - w.query[j]) / std::sqrt(radius2);
    }
    for (int t = 0; t < World::kTargets; ++t) {
      r(i, t) = 0;
      for (std::size_t d = 0; d < World::kDimensions; ++d)
        r(i, t) += static_cast<double>(w.map[static_cast<std::size_t>(t) * World::kDimensions + d]) *
                   static_cast<double>(w.scale[d]) * w.steps_off[point.index * World::kDimensions + d];
    }
  }
  Eigen::MatrixXd normal = x.transpose() * weight.asDiagonal() * x;
  normal(0, 0) += options.intercept_penalty;
  for (int d = 1; d < order; ++d) normal(d, d) += options.slope_penalty * weight.sum();
  const Eigen::MatrixXd solution = normal.ldlt().solve(x.transpose() * weight.asDiagonal() * r);
  Targets out{};
  for (int c = 0; c < World::kTargets; ++c) {
    out[static_cast<std::size_t>(c)] = solution(0, c);
    spread[static_cast<std::size_t>(c)] =
        std::sqrt((weight.array() * r.col(c).array().square()).sum() / weight.sum());
  }
  return out;
}

TEST(LocalRegression, IsTheInterceptOfWeightedLeastSquares) {
  for (const LocalMethod method : {LocalMethod::mean, LocalMethod::linear}) {
    const World w(7);
    const LocalOptions options = {method, 3.5, 0.02};
    Targets spread{};
    const Targets expected = by_normal_equations(w, options, spread);
    const LocalAnswer found = local_regression(w.data, w.query, w.neighbours, options);
    for (std::size_t c = 0; c < World::kTargets; ++c) {
      EXPECT_NEAR(found.correction[c], expected[c], 1e-6 * spread[c]) << c;
      EXPECT_NEAR(found.spread[c], spread[c], 1e-7 * spread[c]) << c;
    }
  }
}

TEST(LocalRegression, WithoutAMethodOnlyTheSpreadIsAnswered) {
  const World w(8);
  const LocalAnswer found = local_regression(w.data, w.query, w.neighbours, {});
  for (std::size_t c = 0; c < World::kTargets; ++c) {
    EXPECT_EQ(found.correction[c], 0);
    EXPECT_GT(found.spread[c], 0);
  }
  const LocalAnswer none = local_regression(w.data, w.query, {}, {});
  for (const double s : none.spread) EXPECT_EQ(s, 0);
}

}  // namespace
}  // namespace im2fit::index
