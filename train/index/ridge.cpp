// SPDX-License-Identifier: Apache-2.0
#include "train/index/ridge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace im2fit::index {
namespace {

constexpr std::ptrdiff_t kBlockRows = 512;
constexpr std::size_t kNoiseRowMax = 8192;  // enough for a covariance of 1,100 features
constexpr double kLeftOut = 1e7;            // a penalty that leaves a group without effect
constexpr std::array<double, 6> kCommonPenalties = {1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0};
constexpr double kWorthwhile = 0.999;  // a choice must gain a thousandth, else the simpler one stays

}  // namespace

RidgeFit RidgeFit::of_targets(std::span<const std::ptrdiff_t> targets) const {
  const auto count = static_cast<std::ptrdiff_t>(targets.size());
  RidgeFit out{RowMatrixF(count, weights.cols()), Eigen::VectorXf(count)};
  for (std::ptrdiff_t t = 0; t < count; ++t) {
    out.weights.row(t) = weights.row(targets[static_cast<std::size_t>(t)]);
    out.bias(t) = bias(targets[static_cast<std::size_t>(t)]);
  }
  return out;
}

RowMatrixF RidgeFit::predict(const RowMatrixF& features) const {
  RowMatrixF y = lab::product_transposed(features, weights);
  y.rowwise() += bias.transpose();
  return y;
}

RidgeTrainer::RidgeTrainer(const TrainingRows& rows, const std::vector<Moments>& folds,
                           std::vector<std::uint32_t> groups)
    : rows_(rows),
      groups_(std::move(groups)),
      fold_rows_(folds.size()),
      folds_(folds),
      total_(rows.features.cols(), rows.targets.cols()) {
  for (std::size_t i = 0; i < rows.fold.size(); ++i)
    fold_rows_[static_cast<std::size_t>(rows.fold[i])].push_back(static_cast<std::int32_t>(i));
  for (const Moments& m : folds) total_ += m;
  accumulate_noise();
}

// What changes between captures of one body is noise, pose or distance: anything but shape.
void RidgeTrainer::accumulate_noise() {
  std::map<std::uint32_t, std::vector<std::int32_t>> captures;
  for (std::size_t i = 0; i < rows_.subject.size(); ++i)
    captures[rows_.subject[i]].push_back(static_cast<std::int32_t>(i));
  std::vector<std::int32_t> used;
  std::vector<std::size_t> starts;
  for (const auto& [subject, members] : captures) {
    if (members.size() < 2) continue;
    if (used.size() + members.size() > kNoiseRowMax) break;
    starts.push_back(used.size());
    used.insert(used.end(), members.begin(), members.end());
    noise_count_ += static_cast<double>(members.size() - 1);
  }
  if (noise_count_ < 100) {  // too few for a covariance
    noise_count_ = 0;
    return;
  }
  starts.push_back(used.size());
  const auto features = rows_.features.cols();
  noise_.setZero(features, features);
  RowMatrixF block;
  for (std::size_t first = 0; first + 1 < starts.size();) {
    std::size_t last = first;
    while (last + 1 < starts.size() && starts[last + 1] - starts[first] <= kBlockRows) ++last;
    last = std::max(last, first + 1);
    block.resize(static_cast<std::ptrdiff_t>(starts[last] - starts[first]), features);
    std::ptrdiff_t row = 0;
    for (std::size_t s = first; s < last; ++s) {
      const auto count = static_cast<std::ptrdiff_t>(starts[s + 1] - starts[s]);
      for (std::ptrdiff_t i = 0; i < count; ++i)
        block.row(row + i) = rows_.features.row(used[starts[s] + static_cast<std::size_t>(i)]);
      auto part = block.middleRows(row, count);
      const Eigen::RowVectorXf mean = part.colwise().mean();
      part.rowwise() -= mean;
      row += count;
    }
    lab::add_gram(block, noise_);
    first = last;
  }
  noise_ /= noise_count_;
}

RidgeFit RidgeTrainer::fit(const Penalty& penalty, int held_out_fold) const {
  const Moments* without = held_out_fold >= 0 ? &folds_[static_cast<std::size_t>(held_out_fold)] : nullptr;
  const double count = total_.count - (without ? without->count : 0);
  Eigen::MatrixXd a = total_.gram;
  Eigen::MatrixXd cross = total_.cross;
  Eigen::VectorXd z_mean = total_.feature_sum;
  Eigen::VectorXd y_mean = total_.target_sum;
  if (without) {
    a.triangularView<Eigen::Lower>() -= without->gram;
    cross -= without->cross;
    z_mean -= without->feature_sum;
    y_mean -= without->target_sum;
  }
  z_mean /= count;
  y_mean /= count;
  a.triangularView<Eigen::Lower>() = a / count;
  a.selfadjointView<Eigen::Lower>().rankUpdate(z_mean, -1.0);
  cross = cross / count - z_mean * y_mean.transpose();
  if (penalty.noise > 0 && has_noise()) a.triangularView<Eigen::Lower>() += penalty.noise * noise_;
  std::ptrdiff_t at = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (std::uint32_t i = 0; i < groups_[g]; ++i, ++at) a(at, at) += penalty.group[g];
  const Eigen::MatrixXd b = lab::solve_positive(std::move(a), cross);
  RidgeFit out;
  out.weights = b.transpose().cast<float>();
  out.bias = (y_mean - b.transpose().lazyProduct(z_mean)).cast<float>();
  return out;
}

Eigen::MatrixXd RidgeTrainer::predict(const RidgeFit& fit, std::span<const std::int32_t> rows) const {
  Eigen::MatrixXd out(static_cast<std::ptrdiff_t>(rows.size()), fit.bias.size());
  RowMatrixF block;
  for (std::size_t at = 0; at < rows.size(); at += kBlockRows) {
    const auto count = std::min<std::ptrdiff_t>(kBlockRows, static_cast<std::ptrdiff_t>(rows.size() - at));
    block.resize(count, rows_.features.cols());
    for (std::ptrdiff_t i = 0; i < count; ++i)
      block.row(i) = rows_.features.row(rows[at + static_cast<std::size_t>(i)]);
    out.middleRows(static_cast<std::ptrdiff_t>(at), count) = fit.predict(block).cast<double>();
  }
  return out;
}

double RidgeTrainer::held_out_error(const Penalty& penalty) const {
  double sum = 0;
  double count = 0;
  for (int f = 0; f < judged_fold_count_; ++f) {
    const auto& members = fold_rows_[static_cast<std::size_t>(f)];
    const Eigen::MatrixXd predicted = predict(fit(penalty, f), members);
    for (std::size_t i = 0; i < members.size(); ++i)
      for (int t = 0; t < judged_target_count_; ++t)
        sum += std::abs(predicted(static_cast<std::ptrdiff_t>(i), t) - rows_.targets(members[i], t));
    count += static_cast<double>(members.size()) * judged_target_count_;
  }
  return sum / count;
}

RidgeTrainer::Choice RidgeTrainer::choose(int judged_target_count) {
  judged_target_count_ = judged_target_count;
  // One fold of 1,000 rows is judge enough; each further one costs a factorisation per choice.
  judged_fold_count_ = total_.count >= 8000 ? 1 : std::min(rows_.fold_count, total_.count >= 400 ? 2 : 4);
  Choice best;
  best.error = 1e300;
  const auto consider = [&](const Penalty& p) {
    const double error = held_out_error(p);
    if (error < best.error * kWorthwhile) {
      best.penalty = p;
      best.error = error;
    }
    return error;
  };
  for (const double common : kCommonPenalties) {
    const double error = consider({std::vector<double>(groups_.size(), common), 0});
    if (error > best.error * 1.05) break;  // past the valley
  }
  if (has_noise())
    for (const double noise : {0.3, 1.0}) {
      Penalty p = best.penalty;
      p.noise = noise;
      consider(p);
    }
  for (int round = 0; groups_.size() > 1 && round < 2; ++round) {
    const double before = best.error;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      for (const double factor : {0.2, 5.0}) {
        const double middle = best.penalty.group[g];
        double step = factor;
        for (int i = 0; i < 3; ++i, step *= factor) {  // keep walking while it pays
          Penalty p = best.penalty;
          p.group[g] = std::clamp(middle * step, 1e-6, 1e3);
          const double last = best.error;
          consider(p);
          if (best.error == last) break;
        }
      }
    }
    if (best.error > before * kWorthwhile) break;
  }
  for (std::size_t g = 0; groups_.size() > 1 && g < groups_.size(); ++g) {
    Penalty p = best.penalty;
    p.group[g] = kLeftOut;
    best.error_without.push_back(held_out_error(p));
  }
  if (groups_.size() == 1) best.error_without.push_back(0);
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (best.error_without[g] > 0 && best.error_without[g] < best.error) {
      best.penalty.group[g] = kLeftOut;
      best.error = held_out_error(best.penalty);
    }
  return best;
}

Eigen::MatrixXd RidgeTrainer::cross_fitted(const Penalty& penalty) const {
  Eigen::MatrixXd out(rows_.targets.rows(), rows_.targets.cols());
  for (int f = 0; f < rows_.fold_count; ++f) {
    const auto& members = fold_rows_[static_cast<std::size_t>(f)];
    const Eigen::MatrixXd part = predict(fit(penalty, f), members);
    for (std::size_t i = 0; i < members.size(); ++i) out.row(members[i]) = part.row(static_cast<std::ptrdiff_t>(i));
  }
  return out;
}

}  // namespace im2fit::index
