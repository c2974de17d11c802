// SPDX-License-Identifier: Apache-2.0
// The arithmetic of one answer, used by query() and by the builder that tunes it. Doubles in written order, only
// + - * / sqrt: the same bits on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/fixed.h"
#include "core/measurement.h"
#include "index/code_tree.h"

namespace im2fit::index {

inline constexpr int kTargetMax = 16;
inline constexpr int kSexTarget = static_cast<int>(kMeasurementCount);  // +1 woman, -1 man
inline constexpr int kTargetMin = kSexTarget + 1;
inline constexpr int kQuadraticDimensionMax = 12;
// 1, each dimension, each product.
constexpr int quadratic_term_count(int dimensions) {
  const int d = dimensions < kQuadraticDimensionMax ? dimensions : kQuadraticDimensionMax;
  return 1 + d + d * (d + 1) / 2;
}
inline constexpr int kQuadraticTermMax = quadratic_term_count(kQuadraticDimensionMax);

// A feature in standard deviations of the training set. Within +-5 of them: one wild bin must not carry the answer. A
// step is 1/4096 of a standard deviation: far below the noise of any measured feature.
using StandardFeature = Fixed<std::int16_t, 12>;
inline constexpr float kStandardFeatureMax = 5.0F;
inline constexpr std::int16_t kStandardFeatureRawMax = 5 * 4096;

// out = (feature - mean) * scale in float32, clipped at +-5, to the nearest StandardFeature (ties to even); 0 where
// the feature is not a number. mean: finite; scale: 0 (the feature never varies: out is 0) or 2^-100 and more, so
// that an instruction set that takes denormal floats for zero gives the same (a product that small is rounded to 0
// anyway). No allocation, thread-safe.
void standardise(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out);

// Rows of weights are padded with zeros to a multiple of this.
inline constexpr int kRowBlock = 16;
constexpr int row_stride(int feature_size) {
  return (feature_size + kRowBlock - 1) / kRowBlock * kRowBlock;
}
// out[r] = sum over i < stride of feature[i] * weights[r * stride + i]. stride: a multiple of kRowBlock; feature:
// within +-kStandardFeatureRawMax, weights: any but -32768. Integers, so exact in any order: two products add up to
// less than 2 * 20480 * 32767 < 2^31 before they are widened. At most 2^18 features. No allocation, thread-safe.
void multiply_rows(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                   std::int64_t* out);

inline constexpr int kGramWidth = 16;  // columns, unused ones 0

// The normal equations of a local regression: sums[j] += w x[j] and products[16 i + j] += (w x[i]) x[j] for j <= i <
// used, row by row, each step rounded to double. rows: 16 values each; `used`: columns at work, 0..16. Products right
// of the diagonal may be written with anything. No allocation, thread-safe.
void add_gram(const double* rows, const double* weights, int count, int used, double* sums, double* products);

// Standardised targets: measurements, sex, then shape latents.
using Targets = std::array<double, kTargetMax>;
using Position = std::array<double, kDimensionMax>;  // in the projected space

// Weights rounded to 16 bits, whole multiples of a 32767th of their target's largest: a target changes by less than
// 2^-16 of its largest weight times the sum of |feature|, 3e-5 of a standard deviation in practice
// (docs/formats-index.md).
struct RoundedWeights {
  std::vector<std::int16_t> weights;  // per target a row of features
  std::vector<float> unit;            // per target: what a weight of 1 stands for
};
RoundedWeights round_weights(std::span<const float> weights, std::size_t feature_size);

// A linear map from standardised features to targets.
class Regressor {
 public:
  // weights: per target a row of features, none -32768; unit, bias: per target.
  Regressor(std::span<const std::int16_t> weights, std::span<const float> unit, std::span<const float> bias);
  std::size_t padded_size() const { return stride_; }
  // standardised: padded_size() values from standardise(), zeros behind the feature's own.
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

// A quadratic over the projected space, for the part that a linear map of the features cannot model. Views.
struct Surface {
  std::span<const float> projection;      // dimensions x target_count
  std::span<const float> inverse_spread;  // dimensions
  std::span<const float> quadratic;       // target_count x quadratic_term_count; empty: flat
  int target_count = 0;
  int dimensions = 0;
  Targets targets_at(const Position& place) const;     // to be added to the regressed ones
  Position shift_of(const Targets& correction) const;  // what that does to a place
};

// What the regression got wrong at an entry (truth less regression in the projected space): four bits a dimension,
// two dimensions a byte, low half first; 1..15 stand for -7..7 steps. A step is half a standard deviation, so that
// the rounding adds two hundredths to the variance of one error, and an error beyond 3.5 of them counts as that.
inline constexpr int kResidualMax = 7;
constexpr std::size_t residual_bytes(int dimensions) {
  return static_cast<std::size_t>(dimensions + 1) / 2;
}
inline int residual_steps(std::span<const std::uint8_t> residuals, int dimensions, std::uint32_t entry,
                          int dimension) {
  const std::uint8_t pair = residuals[entry * residual_bytes(dimensions) + static_cast<std::size_t>(dimension) / 2];
  return (dimension % 2 == 0 ? pair & 15 : pair >> 4) - (kResidualMax + 1);
}

// Entries around the query: their places, and the regression's errors there.
struct LocalData {
  const CodeTree* tree = nullptr;
  std::span<const std::uint8_t> residuals;
  std::span<const float> residual_scale;  // per dimension, projected space per step
  std::span<const float> error_map;       // target_count x dimensions
  int target_count = 0;
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

// Weighted regression of the neighbours' residuals on their places, read off at the query. Its answer is a weighted
// sum of the residuals (a linear smoother). `neighbours`: at most kNeighbourMax, nearest first.
LocalAnswer local_regression(const LocalData& data, const Coordinates& query, std::span<const Neighbour> neighbours,
                             const LocalOptions& options);

}  // namespace im2fit::index
