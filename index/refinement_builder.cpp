// SPDX-License-Identifier: Apache-2.0
#include "index/refinement_builder.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

#include "index/format.h"
#include "index/ridge.h"

namespace im2fit::index {
namespace {

constexpr int kFolds = 3;
constexpr double kPenalties[] = {0.003, 0.01, 0.03, 0.1, 0.3};  // in variances of a value
constexpr std::size_t kStrangersMin = 200;                      // to calibrate on, as for the plain answer

// Standardised as a query does it.
RowMatrixF standardised_rows(FeatureScale& scale, const std::vector<const std::vector<float>*>& values) {
  const auto size = static_cast<std::ptrdiff_t>(values.front()->size());
  RowMatrixF out(static_cast<std::ptrdiff_t>(values.size()), size);
  for (std::size_t i = 0; i < values.size(); ++i)
    scale.standardise(*values[i], {out.row(static_cast<std::ptrdiff_t>(i)).data(), static_cast<std::size_t>(size)});
  return out;
}

// Sums behind a ridge regression.
struct Sums {
  double count = 0;
  Eigen::MatrixXd gram, cross;  // lower triangle of z z^T; z y^T
  Eigen::VectorXd z, y;
  Sums(std::ptrdiff_t values, std::ptrdiff_t targets)
      : gram(Eigen::MatrixXd::Zero(values, values)),
        cross(Eigen::MatrixXd::Zero(values, targets)),
        z(Eigen::VectorXd::Zero(values)),
        y(Eigen::VectorXd::Zero(targets)) {}
  void add(const RowMatrixF& rows, const Eigen::MatrixXd& targets) {
    Eigen::MatrixXf work = Eigen::MatrixXf::Zero(rows.cols(), rows.cols());
    work.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    gram.triangularView<Eigen::Lower>() += work.cast<double>();
    cross += rows.transpose().cast<double>() * targets;
    z += rows.cast<double>().colwise().sum().transpose();
    y += targets.colwise().sum().transpose();
    count += static_cast<double>(rows.rows());
  }
  void add(const Sums& other, double sign) {
    count += sign * other.count;
    gram += sign * other.gram;
    cross += sign * other.cross;
    z += sign * other.z;
    y += sign * other.y;
  }
};

struct Fit {
  Eigen::MatrixXd weights;  // value x target
  Eigen::VectorXd bias;
};

Fit solve(const Sums& s, double penalty) {
  const Eigen::VectorXd z = s.z / s.count, y = s.y / s.count;
  Eigen::MatrixXd a = s.gram / s.count;
  a.selfadjointView<Eigen::Lower>().rankUpdate(z, -1.0);
  a.diagonal().array() += penalty;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> factor(a);
  Fit fit;
  fit.weights = factor.solve(s.cross / s.count - z * y.transpose());
  fit.bias = y - fit.weights.transpose() * z;
  return fit;
}

void answer_rows(const Fit& fit, const RowMatrixF& z, const std::vector<std::ptrdiff_t>& rows,
                 Eigen::MatrixXd& answer) {
  const Eigen::MatrixXd part = (z(rows, Eigen::all).cast<double>() * fit.weights).rowwise() + fit.bias.transpose();
  for (std::size_t i = 0; i < rows.size(); ++i) answer.row(rows[i]) = part.row(static_cast<std::ptrdiff_t>(i));
}

}  // namespace

std::vector<std::ptrdiff_t> RefinementBuilder::all_strangers() const {
  std::vector<std::ptrdiff_t> out;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i].stranger) out.push_back(static_cast<std::ptrdiff_t>(i));
  return out;
}

void RefinementBuilder::add(const Sample& sample) {
  if (!sample.refines() || rows_.size() >= kSampleMax) return;
  if (rows_.empty()) fit_size_ = sample.fit.size();
  Row& row = rows_.emplace_back();
  row.subject = sample.subject;
  row.frame_count = std::max(sample.frame_count, 1);
  row.stranger = sample.calibrate_only;
  row.woman = sample.woman;
  row.truth = sample.truth;
  const Seen seen{sample.feature, sample.fit, sample.back, sample.fit_both};
  for (const Refinement kind : {Refinement::fitted, Refinement::turned}) {
    auto& values = row.values[static_cast<std::size_t>(kind)];
    values.resize(refined_size(kind, sample.feature.size(), fit_size_));
    refined_values(kind, seen, values);
  }
}

void RefinementBuilder::learn(const TargetSpace& targets, const PlainAnswers& plain, std::uint64_t seed,
                              std::uint32_t shape_key) {
  if (rows_.size() < kSampleMin) return;
  for (const Refinement kind : {Refinement::fitted, Refinement::turned}) {
    learned_[static_cast<std::size_t>(kind)] = learn_one(kind, targets, plain, seed);
    learned_[static_cast<std::size_t>(kind)]->record.shape_key = shape_key;
    for (Row& row : rows_) std::vector<float>().swap(row.values[static_cast<std::size_t>(kind)]);
  }
}

RefinementBuilder::Learned RefinementBuilder::learn_one(Refinement kind, const TargetSpace& targets,
                                                        const PlainAnswers& plain, std::uint64_t seed) const {
  const auto count = static_cast<std::ptrdiff_t>(rows_.size());
  std::vector<const std::vector<float>*> values;
  for (const Row& row : rows_) values.push_back(&row.values[static_cast<std::size_t>(kind)]);
  FeatureScale scale(values);
  const RowMatrixF z = standardised_rows(scale, values);
  Eigen::MatrixXd y(count, kTargetMin);
  std::array<std::vector<std::ptrdiff_t>, kFolds> members;
  FoldDealer dealer(seed, kFolds);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    y.row(i) = targets.measured(row.truth, row.woman).transpose();
    members[static_cast<std::size_t>(dealer.fold_of(row.subject))].push_back(i);
  }
  Sums all(z.cols(), kTargetMin);
  std::vector<Sums> folds;
  const auto rows_of = [&](const std::vector<std::ptrdiff_t>& chosen) {
    return std::pair<RowMatrixF, Eigen::MatrixXd>(z(chosen, Eigen::all), y(chosen, Eigen::all));
  };
  for (const auto& chosen : members) {
    const auto [zs, ys] = rows_of(chosen);
    folds.emplace_back(z.cols(), kTargetMin).add(zs, ys);
    all.add(folds.back(), 1);
  }

  Eigen::MatrixXd best_answer;
  double best = 1e300, penalty = kPenalties[0];
  for (const double tried : kPenalties) {
    Eigen::MatrixXd answer(count, kTargetMin);
    for (std::size_t f = 0; f < kFolds; ++f) {
      Sums rest = all;
      rest.add(folds[f], -1);
      answer_rows(solve(rest, tried), z, members[f], answer);
    }
    const double error = (answer - y).cwiseAbs().sum();
    if (error >= best) break;  // past the valley
    best = error;
    penalty = tried;
    best_answer = std::move(answer);
  }

  Learned out;
  out.record.fit_size = static_cast<std::uint32_t>(fit_size_);
  out.record.sample_count = static_cast<std::uint32_t>(count);
  out.record.penalty_millionths = static_cast<std::uint32_t>(std::lround(penalty * 1e6));
  out.mean = scale.mean;
  out.scale = scale.scale;
  const Fit fit = solve(all, penalty);
  for (std::ptrdiff_t t = 0; t < kTargetMin; ++t) {
    const double unit = std::max(fit.weights.col(t).cwiseAbs().maxCoeff(), 1e-12) / 32767;
    out.unit.push_back(static_cast<float>(unit));
    out.bias.push_back(static_cast<float>(fit.bias(t)));
    for (std::ptrdiff_t i = 0; i < fit.weights.rows(); ++i)
      out.weights.push_back(static_cast<std::int16_t>(
          std::clamp<long>(std::lround(fit.weights(i, t) / static_cast<double>(out.unit.back())), -32767, 32767)));
  }

  // Judged on strangers where there are enough, by a regression that has learned from none: the people it will meet
  // are strangers to it as well.
  std::vector<std::ptrdiff_t> judged, strange;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    if (!plain.contains(row.subject)) continue;
    judged.push_back(i);
    if (row.stranger) strange.push_back(i);
  }
  if (strange.size() >= kStrangersMin) {
    judged = strange;
    Sums rest = all;
    const auto [zs, ys] = rows_of(all_strangers());
    Sums strangers(z.cols(), kTargetMin);
    strangers.add(zs, ys);
    rest.add(strangers, -1);
    if (rest.count >= kSampleMin) answer_rows(solve(rest, penalty), z, judged, best_answer);
  }
  if (judged.empty()) return {};
  for (std::size_t t = 0; t < kTargetMin; ++t) {
    double change_square = 1e-12, change_right = 0;
    for (const std::ptrdiff_t i : judged) {
      const double before = plain.at(rows_[static_cast<std::size_t>(i)].subject)[t];
      const auto column = static_cast<std::ptrdiff_t>(t);
      const double change = best_answer(i, column) - before;
      change_square += change * change;
      change_right += change * (y(i, column) - before);
    }
    out.record.share[t] = static_cast<float>(std::clamp(change_right / change_square, 0.0, 1.0));
  }
  std::vector<HeldOut> held_out;
  for (const std::ptrdiff_t i : judged) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    HeldOut h;
    h.subject = static_cast<std::uint32_t>(row.subject);
    h.frame_count = row.frame_count;
    for (std::size_t t = 0; t < kTargetMin; ++t) {
      const auto column = static_cast<std::ptrdiff_t>(t);
      const double before = plain.at(row.subject)[t];
      h.truth[t] = y(i, column);
      h.answer[t] = before + static_cast<double>(out.record.share[t]) * (best_answer(i, column) - before);
      if (t < kMeasurementCount)
        out.record.mae[t] += static_cast<float>(targets.scale(t) * std::abs(h.truth[t] - h.answer[t]) /
                                                static_cast<double>(judged.size()));
    }
    held_out.push_back(h);
  }
  const IntervalModel intervals = calibrate_intervals(held_out);
  out.record.interval_kind = static_cast<std::uint32_t>(intervals.kind);
  out.record.frame_model = intervals.frame_model;
  out.record.frame_noise = intervals.frame_noise;
  out.record.coverage = intervals.coverage;
  out.interval.assign(intervals.quantiles.begin(), intervals.quantiles.end());
  out.spread_floor.assign(intervals.spread_floor.begin(), intervals.spread_floor.end());
  out.sex_table = calibrate_sex(held_out, targets.mean(kSexTarget), targets.scale(kSexTarget));
  return out;
}

void RefinementBuilder::write(ContainerWriter& out) const {
  for (const Refinement kind : {Refinement::fitted, Refinement::turned}) {
    const auto& learned = learned_[static_cast<std::size_t>(kind)];
    if (!learned || learned->mean.empty()) continue;
    const auto add = [&](const char* name, const auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      out.add_array(section_of(kind, name), std::span<const Value>(values));
    };
    out.add_array(section_of(kind, "about"), std::span<const RefinementRecord>(&learned->record, 1));
    add("mean", learned->mean);
    add("scale", learned->scale);
    add("weights", learned->weights);
    add("unit", learned->unit);
    add("bias", learned->bias);
    add("interval", learned->interval);
    add("spread", learned->spread_floor);
    add("sex", learned->sex_table);
  }
}

}  // namespace im2fit::index
