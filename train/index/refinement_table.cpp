// SPDX-License-Identifier: Apache-2.0
#include "train/index/refinement_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "index/format.h"
#include "index/refinement.h"

namespace im2fit::index {
namespace {

using lab::RowMatrixF;

constexpr double kPenalties[] = {0.003, 0.01, 0.03, 0.1, 0.3};  // in variances of a value
// What differs between two captures of the same body counts by this much of its variance as a penalty, so that poses
// and noise move the answer less (errors in variables; docs/formats-index.md has what other values cost).
constexpr double kSameBody = 0.25;

// Standardised as a query does it.
RowMatrixF standardised_rows(FeatureScale& scale, const std::vector<const std::vector<float>*>& values) {
  const auto size = static_cast<std::ptrdiff_t>(values.front()->size());
  RowMatrixF out(static_cast<std::ptrdiff_t>(values.size()), size);
  for (std::size_t i = 0; i < values.size(); ++i)
    scale.standardise(*values[i], {out.row(static_cast<std::ptrdiff_t>(i)).data(), static_cast<std::size_t>(size)});
  return out;
}

// Means and scales as the file keeps them.
FeatureScale file_scale(const std::vector<const std::vector<float>*>& values) {
  FeatureScale scale(values);
  for (auto* part : {&scale.mean, &scale.scale})
    for (float& v : *part) v = float_of_upper(upper_of_float(v));
  return scale;
}

}  // namespace

RegressionSums::RegressionSums(std::ptrdiff_t values, std::ptrdiff_t targets)
    : gram(Eigen::MatrixXd::Zero(values, values)),
      cross(Eigen::MatrixXd::Zero(values, targets)),
      z(Eigen::VectorXd::Zero(values)),
      y(Eigen::VectorXd::Zero(targets)) {}

void RegressionSums::add(const RowMatrixF& rows, const Eigen::MatrixXd& targets, const Eigen::VectorXd& weights) {
  const RowMatrixF scaled = weights.cwiseSqrt().cast<float>().asDiagonal() * rows;
  lab::add_gram(scaled, gram);
  const Eigen::MatrixXd weighted = weights.asDiagonal() * targets;
  const Eigen::MatrixXd values = rows.cast<double>();
  cross += lab::transposed_product(values, weighted);
  z += lab::transposed_product(values, weights);
  y += weighted.colwise().sum().transpose();
  weight += weights.sum();
  count += rows.rows();
}

void RegressionSums::add(const RegressionSums& other, int sign) {
  count += sign * other.count;
  weight += sign * other.weight;
  gram += sign * other.gram;
  cross += sign * other.cross;
  z += sign * other.z;
  y += sign * other.y;
}

LinearFit solve(const RegressionSums& s, const Eigen::MatrixXd& unlike, const Eigen::VectorXd& penalties) {
  const Eigen::VectorXd z = s.z / s.weight, y = s.y / s.weight;
  Eigen::MatrixXd a = s.gram / s.weight;
  a.triangularView<Eigen::Lower>() -= z * z.transpose();
  a.triangularView<Eigen::Lower>() += kSameBody * unlike;
  a.diagonal() += penalties;
  LinearFit fit;
  fit.weights = lab::solve_positive(std::move(a), s.cross / s.weight - z * y.transpose());
  fit.bias = y - lab::transposed_product(fit.weights, z);
  return fit;
}

RefinementTable::RefinementTable(const std::vector<const std::vector<float>*>& values, Eigen::MatrixXd targets,
                                 Eigen::VectorXd weights, const std::vector<int>& fold_of_row)
    : scale(file_scale(values)),
      z(standardised_rows(scale, values)),
      y(std::move(targets)),
      weight(std::move(weights)),
      all(z.cols(), y.cols()),
      unlike(Eigen::MatrixXd::Zero(z.cols(), z.cols())) {
  for (std::size_t i = 0; i < fold_of_row.size(); ++i)
    of_fold[static_cast<std::size_t>(fold_of_row[i])].push_back(static_cast<std::ptrdiff_t>(i));
  for (const auto& rows : of_fold) {
    folds.push_back(sums_of(rows));
    all.add(folds.back(), 1);
  }
}

RegressionSums RefinementTable::sums_of(const std::vector<std::ptrdiff_t>& rows) const {
  RegressionSums sums(z.cols(), y.cols());
  if (!rows.empty()) sums.add(z(rows, Eigen::all), y(rows, Eigen::all), weight(rows));
  return sums;
}

Eigen::MatrixXd RefinementTable::unlike_of(const Repeats& repeats) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(z.cols(), z.cols());
  if (repeats.empty()) return out;
  RowMatrixF rows(static_cast<std::ptrdiff_t>(repeats.size()), z.cols());
  double sum = 0;
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const auto [a, b] = repeats[i];
    const double counts = std::min(weight(a), weight(b));
    rows.row(static_cast<std::ptrdiff_t>(i)) = (z.row(a) - z.row(b)) * static_cast<float>(std::sqrt(counts));
    sum += counts;
  }
  lab::add_gram(rows, out);
  out /= sum;
  return out;
}

RegressionSums RefinementTable::without(const RegressionSums& some) const {
  RegressionSums rest = all;
  rest.add(some, -1);
  return rest;
}

void RefinementTable::answer(const LinearFit& fit, const std::vector<std::ptrdiff_t>& rows,
                             Eigen::MatrixXd& out) const {
  const Eigen::MatrixXd values = z(rows, Eigen::all).cast<double>();
  const Eigen::MatrixXd part = lab::product(values, fit.weights).rowwise() + fit.bias.transpose();
  for (std::size_t i = 0; i < rows.size(); ++i) out.row(rows[i]) = part.row(static_cast<std::ptrdiff_t>(i));
}

CrossFit choose_penalty(const RefinementTable& table, const Eigen::VectorXd& shares) {
  CrossFit best;
  double least = 1e300;
  for (const double tried : kPenalties) {
    Eigen::MatrixXd answer(table.z.rows(), table.y.cols());
    for (std::size_t f = 0; f < kRefinementFolds; ++f)
      table.answer(solve(table.without(table.folds[f]), table.unlike, tried * shares), table.of_fold[f], answer);
    const double error = (answer - table.y).cwiseAbs().sum();
    if (error >= least) break;  // past the valley
    least = error;
    best = {tried, std::move(answer)};
  }
  return best;
}

Eigen::MatrixXd answer_unknown_clothes(const RefinementTable& table, const std::vector<int>& kind_of_row,
                                       const Repeats& repeats, const Eigen::VectorXd& penalties,
                                       std::vector<bool>& met_none) {
  Eigen::MatrixXd answer = Eigen::MatrixXd::Zero(table.z.rows(), table.y.cols());
  met_none.assign(kind_of_row.size(), false);
  for (int kind = 0; kind < kClothesKindMax; ++kind) {
    std::array<std::vector<std::ptrdiff_t>, kRefinementFolds> rows;
    RegressionSums of_kind(table.z.cols(), table.y.cols());
    for (std::size_t f = 0; f < kRefinementFolds; ++f) {
      for (const std::ptrdiff_t i : table.of_fold[f])
        if (kind_of_row[static_cast<std::size_t>(i)] == kind) rows[f].push_back(i);
      of_kind.add(table.sums_of(rows[f]), 1);
    }
    if (of_kind.count == 0) continue;
    // What two captures of a body differ by is what clothes change, too: those of this kind must not tell of it.
    Repeats others;
    for (const auto& [a, b] : repeats)
      if (kind_of_row[static_cast<std::size_t>(a)] != kind && kind_of_row[static_cast<std::size_t>(b)] != kind)
        others.push_back({a, b});
    const Eigen::MatrixXd unlike = table.unlike_of(others);
    for (std::size_t f = 0; f < kRefinementFolds; ++f) {
      RegressionSums rest = table.without(table.folds[f]);
      rest.add(of_kind, -1);
      rest.add(table.sums_of(rows[f]), 1);  // taken off twice
      if (rows[f].empty() || rest.count < static_cast<std::ptrdiff_t>(kRefinementSampleMin)) continue;
      table.answer(solve(rest, unlike, penalties), rows[f], answer);
      for (const std::ptrdiff_t i : rows[f]) met_none[static_cast<std::size_t>(i)] = true;
    }
  }
  return answer;
}

}  // namespace im2fit::index
