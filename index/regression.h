// SPDX-License-Identifier: Apache-2.0
// The arithmetic of one answer, used by query() and by the builder that tunes it. Doubles in written order, only
// + - * / sqrt: the same bits on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "index/code_tree.h"
#include "kernels/core/measurement.h"

namespace im2fit::index {

inline constexpr int kTargetMax = 16;
inline constexpr int kSexTarget = static_cast<int>(kMeasurementCount);  // +1 woman, -1 man
inline constexpr int kTargetMin = kSexTarget + 1;
inline constexpr float kClipSd = 5.0F;  // of a standardised feature: one wild bin must not carry the answer
inline constexpr int kQuadraticDimensionMax = 12;
// 1, each dimension, each product.
constexpr int quadratic_term_count(int dimensions) {
  const int d = dimensions < kQuadraticDimensionMax ? dimensions : kQuadraticDimensionMax;
  return 1 + d + d * (d + 1) / 2;
}
inline constexpr int kQuadraticTermMax = quadratic_term_count(kQuadraticDimensionMax);

// Standardised targets: measurements, sex, then shape latents.
using Targets = std::array<double, kTargetMax>;
using Position = std::array<double, kDimensionMax>;  // in the projected space

// (x - mean) * scale, clipped; 0 for NaN and for features that never vary (scale 0). For training; a query's feature
// is made fixed point by kernels/standardise.
void standardise(std::span<const float> feature, std::span<const float> mean, std::span<const float> scale,
                 std::span<float> out);

// A linear map from standardised features to targets, its weights rounded to 16 bits per target when it is made: a
// target changes by less than 2^-16 of its largest weight times the sum of |feature|, 3e-5 of a standard deviation in
// practice (docs/formats-index.md).
class Regressor {
 public:
  // weights: per target a row of features.
  Regressor(std::span<const float> weights, std::span<const float> bias, std::size_t feature_size);
  std::size_t padded_size() const { return stride_; }
  // standardised: padded_size() values from kernels/standardise, zeros behind the feature's own.
  Targets operator()(std::span<const std::int16_t> standardised) const;

 private:
  std::size_t stride_;
  std::vector<std::int16_t> weights_;
  std::vector<double> unit_;  // per target: of a product of raws
  std::vector<double> bias_;
};

// matrix: per dimension a row of `target_count`.
Position project(const Targets& targets, int target_count, std::span<const float> matrix, int dimensions);
Coordinates to_grid(const Position& position, int dimensions, double grid_unit);

// Products of position/spread, each clipped at +-4 so that the surface is not followed far outside the data.
void quadratic_terms(const Position& position, std::span<const float> inverse_spread, int dimensions,
                     std::span<double> out);
// weights: per target a row of terms.
Targets apply_quadratic(std::span<const double> terms, std::span<const float> weights, int target_count);

// Training points around the query: where they lie (codes), and what the regression got wrong there (residuals).
struct LocalData {
  std::span<const std::int8_t> codes;
  Coordinates steps{};
  int dimensions = 0;
  std::span<const std::int16_t> residuals;  // a row per point, in units of residual_scale
  std::span<const float> residual_scale;
  int target_count = 0;  // columns looked at, the first of each row
  int row_size = 0;
};

enum class LocalMethod : std::uint32_t { none, mean, linear };

struct LocalOptions {
  LocalMethod method = LocalMethod::none;
  double intercept_penalty = 0;  // in neighbours of full weight: pulls the correction to zero
  double slope_penalty = 0;      // share of the neighbours' total weight: pulls `linear` to `mean`
};

struct LocalAnswer {
  Targets correction{};
  Targets spread{};  // root mean square of the residuals nearby
};

// What a local regression makes of the neighbours' places alone. Its answer is a weighted sum of their residuals (a
// linear smoother), so the weights serve any number of columns.
struct LocalWeights {
  std::array<double, kNeighbourMax> kernel;     // biweight; its radius is the farthest neighbour's distance
  std::array<double, kNeighbourMax> influence;  // on the answer; zeros for LocalMethod::none
  std::size_t count = 0;
  double total = 0;  // of the kernel
};
// `neighbours`: at most kNeighbourMax, nearest first. Of `data` codes, steps and dimensions are used.
void fit_local(const LocalData& data, const Coordinates& query, std::span<const Neighbour> neighbours,
               const LocalOptions& options, LocalWeights& out);
LocalAnswer apply_local(const LocalWeights& weights, const LocalData& data, std::span<const Neighbour> neighbours);
// Both.
LocalAnswer local_regression(const LocalData& data, const Coordinates& query, std::span<const Neighbour> neighbours,
                             const LocalOptions& options);

}  // namespace im2fit::index
