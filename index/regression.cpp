// SPDX-License-Identifier: Apache-2.0
#include "index/regression.h"

#include <algorithm>
#include <cmath>

namespace im2fit::index {
namespace {

constexpr int kOrderMax = kDimensionMax + 1;
constexpr double kPositionClip = 4.0;

// Normal equations of weighted least squares: intercept first, then the slopes.
struct NormalEquations {
  std::array<std::array<double, kOrderMax>, kOrderMax> matrix{};
  std::array<Targets, kOrderMax> right{};
};

// In place Cholesky factorisation and solution (Golub & Van Loan, algorithm 4.2.1); the matrix is positive definite
// because every diagonal element carries a penalty. Only the first row of the solution is needed.
Targets solve_intercept(NormalEquations& eq, int order, int target_count) {
  auto& a = eq.matrix;
  for (int j = 0; j < order; ++j) {
    for (int k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
    a[j][j] = std::sqrt(std::max(a[j][j], 1e-12));
    for (int i = j + 1; i < order; ++i) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] /= a[j][j];
    }
  }
  Targets out{};
  for (int t = 0; t < target_count; ++t) {
    std::array<double, kOrderMax> x{};
    for (int i = 0; i < order; ++i) {
      double sum = eq.right[i][t];
      for (int k = 0; k < i; ++k) sum -= a[i][k] * x[k];
      x[i] = sum / a[i][i];
    }
    for (int i = order - 1; i >= 0; --i) {
      for (int k = i + 1; k < order; ++k) x[i] -= a[k][i] * x[k];
      x[i] /= a[i][i];
    }
    out[t] = x[0];
  }
  return out;
}

}  // namespace

void standardise(std::span<const float> feature, std::span<const float> mean, std::span<const float> scale,
                 std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    float z = 0;
    if (scale[i] > 0 && !std::isnan(feature[i])) z = (feature[i] - mean[i]) * scale[i];
    out[i] = std::clamp(z, -kClipSd, kClipSd);
  }
}

Targets regress(std::span<const float> standardised, std::span<const float> weights, std::span<const float> bias) {
  Targets out{};
  const std::size_t count = standardised.size();
  for (std::size_t t = 0; t < bias.size(); ++t) {
    const float* row = weights.data() + t * count;
    double sum = static_cast<double>(bias[t]);
    for (std::size_t i = 0; i < count; ++i) sum += static_cast<double>(row[i]) * static_cast<double>(standardised[i]);
    out[t] = sum;
  }
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

LocalAnswer local_regression(const LocalData& data, const Coordinates& query, std::span<const Neighbour> neighbours,
                             const LocalOptions& options) {
  LocalAnswer answer;
  if (neighbours.empty()) return answer;
  const int order = options.method == LocalMethod::linear ? data.dimensions + 1 : 1;
  const double radius2 = static_cast<double>(neighbours.back().distance) + 1.0;
  const double radius = std::sqrt(radius2);
  NormalEquations eq;
  Targets squares{};
  for (const Neighbour& n : neighbours) {
    const double u = 1.0 - static_cast<double>(n.distance) / radius2;
    const double w = u * u;
    std::array<double, kOrderMax> x{};
    x[0] = 1;
    const std::int8_t* code = data.codes.data() + static_cast<std::size_t>(n.index) * kDimensionMax;
    for (int d = 1; d < order; ++d)
      x[d] = static_cast<double>(code[d - 1] * data.steps[d - 1] - query[d - 1]) / radius;
    const std::int16_t* residual = data.residuals.data() + static_cast<std::size_t>(n.index) * data.row_size;
    for (int i = 0; i < order; ++i) {
      const double wx = w * x[i];
      for (int j = 0; j <= i; ++j) eq.matrix[i][j] += wx * x[j];
      for (int t = 0; t < data.target_count; ++t) eq.right[i][t] += wx * residual[t];
    }
    for (int t = 0; t < data.target_count; ++t) squares[t] += w * residual[t] * residual[t];
  }
  const double total = eq.matrix[0][0] > 1e-9 ? eq.matrix[0][0] : 1e-9;
  for (int t = 0; t < data.target_count; ++t)
    answer.spread[t] = std::sqrt(squares[t] / total) * static_cast<double>(data.residual_scale[t]);
  if (options.method == LocalMethod::none) return answer;
  eq.matrix[0][0] += options.intercept_penalty + 1e-9;
  for (int i = 1; i < order; ++i) eq.matrix[i][i] += options.slope_penalty * total + 1e-9;
  answer.correction = solve_intercept(eq, order, data.target_count);
  for (int t = 0; t < data.target_count; ++t) answer.correction[t] *= static_cast<double>(data.residual_scale[t]);
  return answer;
}

}  // namespace im2fit::index
