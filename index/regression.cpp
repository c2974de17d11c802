// SPDX-License-Identifier: Apache-2.0
#include "index/regression.h"

#include <algorithm>
#include <cmath>

#include "core/cholesky.h"

namespace im2fit::index {
namespace {

constexpr std::size_t kOrderMax = kDimensionMax + 1;
constexpr double kPositionClip = 4.0;

// Normal equations of weighted least squares: intercept first, then the slopes; lower triangle.
static_assert(kGramWidth == kDimensionMax);
using Gram = std::array<std::array<double, kOrderMax>, kOrderMax>;

// The first row of the inverse; the matrix is positive definite because every diagonal element carries a penalty.
std::array<double, kOrderMax> first_of_inverse(Gram& a, std::size_t order) {
  constexpr double kPivotMin = 1e-12;
  cholesky_factor(a, order, kPivotMin);
  std::array<double, kOrderMax> x{};
  x[0] = 1;
  cholesky_solve(a, order, x);
  return x;
}

std::int16_t standardise_one(float feature, float mean, float scale) {
  float z = (feature - mean) * scale;
  if (z != z) z = 0;  // not measured, or infinite where scale is 0
  z = z > kStandardFeatureMax ? kStandardFeatureMax : z;
  z = z < -kStandardFeatureMax ? -kStandardFeatureMax : z;
  // Adding 1.5 * 2^23 leaves no fraction bits: the sum is rounded to a whole number, ties to even.
  constexpr float kWhole = 12582912.0F;
  return static_cast<std::int16_t>((z * 4096.0F + kWhole) - kWhole);
}

}  // namespace

void standardise(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  for (int i = 0; i < count; ++i) out[i] = standardise_one(feature[i], mean[i], scale[i]);
}

void multiply_rows(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                   std::int64_t* out) {
  for (int r = 0; r < row_count; ++r, weights += stride) {
    std::int64_t sum = 0;
    for (int i = 0; i < stride; i += 2) sum += feature[i] * weights[i] + feature[i + 1] * weights[i + 1];
    out[r] = sum;
  }
}

void add_gram(const double* rows, const double* weights, int count, int used, double* sums, double* products) {
  for (int n = 0; n < count; ++n, rows += kGramWidth) {
    const double* __restrict x = rows;
    for (int j = 0; j < kGramWidth; ++j) sums[j] += weights[n] * x[j];
    for (int i = 0; i < used; ++i) {
      double* __restrict product = products + i * kGramWidth;
      const double wx = weights[n] * x[i];
      const int last = i | 3;  // whole vectors
      for (int j = 0; j <= last; ++j) product[j] += wx * x[j];
    }
  }
}

RoundedWeights round_weights(std::span<const float> weights, std::size_t feature_size) {
  constexpr double kWeightMax = 32767;
  RoundedWeights out;
  for (std::size_t first = 0; first < weights.size(); first += feature_size) {
    const auto row = weights.subspan(first, feature_size);
    double largest = 0;
    for (const float w : row) largest = std::max(largest, std::abs(static_cast<double>(w)));
    out.unit.push_back(largest > 0 ? static_cast<float>(largest / kWeightMax) : 1.0F);
    const auto unit = static_cast<double>(out.unit.back());
    for (const float w : row) {
      const double raw = unit > 0 ? static_cast<double>(w) / unit : 0;
      out.weights.push_back(
          static_cast<std::int16_t>(std::clamp(raw < 0 ? raw - 0.5 : raw + 0.5, -kWeightMax, kWeightMax)));
    }
  }
  return out;
}

Regressor::Regressor(std::span<const std::int16_t> weights, std::span<const float> unit, std::span<const float> bias)
    : bias_(bias.begin(), bias.end()) {
  const std::size_t feature_size = bias.empty() ? 0 : weights.size() / bias.size();
  stride_ = static_cast<std::size_t>(row_stride(static_cast<int>(feature_size)));
  weights_.resize(stride_ * bias.size());
  for (std::size_t t = 0; t < bias.size(); ++t) {
    std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(t * feature_size), feature_size,
                weights_.begin() + static_cast<std::ptrdiff_t>(t * stride_));
    unit_.push_back(static_cast<double>(unit[t]) * StandardFeature::from_raw(1).real());
  }
}

Targets Regressor::operator()(std::span<const std::int16_t> standardised) const {
  std::array<std::int64_t, kTargetMax> sums{};
  multiply_rows(standardised.data(), weights_.data(), static_cast<int>(stride_), static_cast<int>(bias_.size()),
                sums.data());
  Targets out{};
  for (std::size_t t = 0; t < bias_.size(); ++t) out[t] = bias_[t] + unit_[t] * static_cast<double>(sums[t]);
  return out;
}

Position project(const Targets& targets, int target_count, std::span<const float> matrix, int dimensions) {
  Position out{};
  for (int d = 0; d < dimensions; ++d) {
    const float* row = matrix.data() + d * target_count;
    double sum = 0;
    for (int t = 0; t < target_count; ++t) sum += static_cast<double>(row[t]) * targets[t];
    out[d] = sum;
  }
  return out;
}

Coordinates to_grid(const Position& position, int dimensions, double grid_unit) {
  Coordinates out{};
  constexpr double kBound = kCoordinateMax;
  for (int d = 0; d < dimensions; ++d) {
    const double x = std::clamp(position[d] / grid_unit, -kBound, kBound);
    out[d] = static_cast<std::int32_t>(x >= 0 ? x + 0.5 : x - 0.5);
  }
  return out;
}

void quadratic_terms(const Position& position, std::span<const float> inverse_spread, int dimensions,
                     std::span<double> out) {
  const int count = std::min(dimensions, kQuadraticDimensionMax);
  std::array<double, kQuadraticDimensionMax> x{};
  std::size_t n = 0;
  out[n++] = 1;
  for (int i = 0; i < count; ++i) {
    x[i] = std::clamp(position[i] * static_cast<double>(inverse_spread[i]), -kPositionClip, kPositionClip);
    out[n++] = x[i];
  }
  for (int i = 0; i < count; ++i)
    for (int j = i; j < count; ++j) out[n++] = x[i] * x[j];
}

Targets apply_quadratic(std::span<const double> terms, std::span<const float> weights, int target_count) {
  Targets out{};
  for (int t = 0; t < target_count; ++t) {
    const float* row = weights.data() + static_cast<std::size_t>(t) * terms.size();
    double sum = 0;
    for (std::size_t i = 0; i < terms.size(); ++i) sum += static_cast<double>(row[i]) * terms[i];
    out[t] = sum;
  }
  return out;
}

Targets Surface::targets_at(const Position& place) const {
  if (quadratic.empty()) return {};
  std::array<double, kQuadraticTermMax> buffer{};
  const auto terms = std::span(buffer).first(static_cast<std::size_t>(quadratic_term_count(dimensions)));
  quadratic_terms(place, inverse_spread, dimensions, terms);
  return apply_quadratic(terms, quadratic, target_count);
}

Position Surface::shift_of(const Targets& correction) const {
  return project(correction, target_count, projection, dimensions);
}

namespace {

// What a local regression makes of the neighbours' places alone.
struct Weights {
  std::array<double, kNeighbourMax> kernel;     // biweight; its radius is the farthest neighbour's distance
  std::array<double, kNeighbourMax> influence;  // on the answer; zeros for LocalMethod::none
  double total = 0;                             // of the kernel
};
constexpr std::size_t kChunk = 32;  // rows at a time: 4 KiB
using Rows = std::array<double, kChunk * kGramWidth>;

class Places {
 public:
  Places(const CodeTree& tree, const Coordinates& query, double scale) : tree_(tree), query_(query), scale_(scale) {}
  // kGramWidth values, zeros behind the dimensions.
  void operator()(std::uint32_t entry, double* x) const {
    std::fill_n(x, kGramWidth, 0.0);
    for (std::size_t d = 0; d < static_cast<std::size_t>(tree_.dimension_count); ++d)
      x[d] = static_cast<double>(tree_.code(entry, d) * tree_.steps[d] - query_[d]) * scale_;
  }

 private:
  const CodeTree& tree_;
  const Coordinates& query_;
  double scale_;
};

// fill(neighbour, row) for all; the weighted sums and products of the rows' first `columns`.
template <class Fill>
void weighted_gram(std::span<const Neighbour> neighbours, const double* weights, int columns, Fill fill, double* sums,
                   double* products) {
  Rows rows;
  for (std::size_t first = 0; first < neighbours.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, neighbours.size() - first);
    for (std::size_t n = 0; n < count; ++n) fill(neighbours[first + n], rows.data() + n * kGramWidth);
    add_gram(rows.data(), weights + first, static_cast<int>(count), columns, sums, products);
  }
}

void fit_local(const LocalData& data, const Coordinates& query, std::span<const Neighbour> neighbours,
               const LocalOptions& options, Weights& out) {
  const auto order =
      static_cast<std::size_t>(options.method == LocalMethod::linear ? data.tree->dimension_count + 1 : 1);
  const double radius2 = static_cast<double>(neighbours.back().distance) + 1.0;
  const double inverse2 = 1.0 / radius2;
  const Places place(*data.tree, query, 1.0 / std::sqrt(radius2));
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    const double u = 1.0 - static_cast<double>(neighbours[n].distance) * inverse2;
    out.kernel[n] = u * u;
    out.total += u * u;
  }
  Gram gram{};
  if (order > 1) {
    std::array<double, kGramWidth> sums{};
    std::array<double, kGramWidth * kGramWidth> products{};
    weighted_gram(
        neighbours, out.kernel.data(), static_cast<int>(order) - 1,
        [&](const Neighbour& n, double* x) { place(n.index, x); }, sums.data(), products.data());
    for (std::size_t i = 1; i < order; ++i) {
      gram[i][0] = sums[i - 1];
      std::copy_n(products.begin() + static_cast<std::ptrdiff_t>((i - 1) * kGramWidth), i, gram[i].begin() + 1);
    }
  }
  gram[0][0] = out.total;
  const double total = std::max(out.total, 1e-9);
  gram[0][0] += options.intercept_penalty + 1e-9;
  for (std::size_t i = 1; i < order; ++i) gram[i][i] += options.slope_penalty * total + 1e-9;
  const std::array<double, kOrderMax> z = first_of_inverse(gram, order);
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    double sum = z[0];
    if (order > 1) {
      std::array<double, kGramWidth> x;
      place(neighbours[n].index, x.data());
      for (std::size_t d = 0; d + 1 < order; ++d) sum += z[d + 1] * x[d];
    }
    out.influence[n] = options.method == LocalMethod::none ? 0 : out.kernel[n] * sum;
  }
}

}  // namespace

LocalAnswer local_regression(const LocalData& data, const Coordinates& query, std::span<const Neighbour> neighbours,
                             const LocalOptions& options) {
  LocalAnswer answer;
  if (neighbours.empty()) return answer;
  Weights weights;
  fit_local(data, query, neighbours, options, weights);
  const int dimensions = data.tree->dimension_count;
  std::array<double, kDimensionMax> correction{};
  std::array<double, kGramWidth> sums{};
  std::array<double, kGramWidth * kGramWidth> products{};
  std::size_t n = 0;
  weighted_gram(
      neighbours, weights.kernel.data(), dimensions,
      [&](const Neighbour& neighbour, double* row) {
        std::fill_n(row, kGramWidth, 0.0);
        for (int d = 0; d < dimensions; ++d) {
          row[d] = static_cast<double>(data.residual_scale[static_cast<std::size_t>(d)]) *
                   residual_steps(data.residuals, dimensions, neighbour.index, d);
          correction[static_cast<std::size_t>(d)] += weights.influence[n] * row[d];
        }
        ++n;
      },
      sums.data(), products.data());
  const double total = std::max(weights.total, 1e-9);
  for (int t = 0; t < data.target_count; ++t) {
    const float* map = data.error_map.data() + t * dimensions;
    double value = 0, square = 0;
    for (int i = 0; i < dimensions; ++i) {
      const auto m = static_cast<double>(map[i]);
      value += m * correction[static_cast<std::size_t>(i)];
      // Below the diagonal only; what lies off it counts twice.
      double row = 0.5 * m * products[static_cast<std::size_t>(i * kGramWidth + i)];
      for (int j = 0; j < i; ++j)
        row += static_cast<double>(map[j]) * products[static_cast<std::size_t>(i * kGramWidth + j)];
      square += 2 * m * row;
    }
    answer.correction[static_cast<std::size_t>(t)] = value;
    answer.spread[static_cast<std::size_t>(t)] = std::sqrt(std::max(square, 0.0) / total);
  }
  return answer;
}

}  // namespace im2fit::index
