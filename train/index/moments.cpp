// SPDX-License-Identifier: Apache-2.0
#include "train/index/moments.h"

#include <algorithm>
#include <cmath>

#include "train/common/linear_algebra.h"

namespace im2fit::index {
namespace {
constexpr std::ptrdiff_t kBlockRows = 128;
}

double rounded_target(double standardised) {
  return std::round(std::clamp(standardised, -kTargetBound, kTargetBound) / kTargetStep) * kTargetStep;
}

Moments::Moments(std::ptrdiff_t features, std::ptrdiff_t targets) {
  gram.setZero(features, features);
  cross.setZero(features, targets);
  feature_sum.setZero(features);
  target_sum.setZero(targets);
}

Moments& Moments::operator+=(const Moments& other) {
  count += other.count;
  gram += other.gram;
  cross += other.cross;
  feature_sum += other.feature_sum;
  target_sum += other.target_sum;
  return *this;
}

FoldMoments::FoldMoments(std::ptrdiff_t features, std::ptrdiff_t targets, int fold_count)
    : folds_(static_cast<std::size_t>(fold_count), Moments(features, targets)), pending_(folds_.size()) {
  for (Pending& p : pending_) {
    p.z.resize(kBlockRows, features);
    p.y.resize(kBlockRows, targets);
  }
}

void FoldMoments::add(int fold, std::span<const float> z, const Eigen::VectorXd& y) {
  Pending& p = pending_[static_cast<std::size_t>(fold)];
  for (std::size_t i = 0; i < z.size(); ++i) p.z(p.rows, static_cast<std::ptrdiff_t>(i)) = static_cast<double>(z[i]);
  p.y.row(p.rows) = y.transpose();
  if (++p.rows == kBlockRows) flush(static_cast<std::size_t>(fold));
}

void FoldMoments::flush(std::size_t fold) {
  Pending& p = pending_[fold];
  Moments& m = folds_[fold];
  const auto z = p.z.topRows(p.rows);
  const auto y = p.y.topRows(p.rows);
  lab::add_gram(z, m.gram);
  m.cross += lab::transposed_product(z, y);
  m.feature_sum += z.colwise().sum().transpose();
  m.target_sum += y.colwise().sum().transpose();
  m.count += static_cast<double>(p.rows);
  p.rows = 0;
}

const std::vector<Moments>& FoldMoments::folds() {
  for (std::size_t f = 0; f < folds_.size(); ++f) flush(f);
  return folds_;
}

}  // namespace im2fit::index
