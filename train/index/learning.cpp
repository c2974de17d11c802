// SPDX-License-Identifier: Apache-2.0
#include "train/index/learning.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/rng.h"
#include "train/common/linear_algebra.h"
#include "train/index/moments.h"

namespace im2fit::index {
namespace {

constexpr double kVarianceMin = 1e-10;  // relative to the mean's square: below it a feature is a constant
constexpr int kLatentMax = kTargetMax - kTargetMin;
constexpr std::size_t kLatentSubjectsMin = 200;

std::vector<const Sample*> one_of_each_subject(const std::vector<Sample>& samples) {
  std::vector<const Sample*> out;
  for (const Sample& s : samples)
    if (out.empty() || out.back()->subject != s.subject) out.push_back(&s);
  return out;
}

std::vector<const std::vector<float>*> features_of(const std::vector<Sample>& samples) {
  std::vector<const std::vector<float>*> out;
  out.reserve(samples.size());
  for (const Sample& s : samples) out.push_back(&s.feature);
  return out;
}

}  // namespace

FeatureScale::FeatureScale(const std::vector<Sample>& samples) : FeatureScale(features_of(samples)) {}

FeatureScale::FeatureScale(const std::vector<const std::vector<float>*>& rows) {
  const std::size_t size = rows.front()->size();
  std::vector<double> count(size), sum(size), square(size);
  for (const std::vector<float>* row : rows)
    for (std::size_t i = 0; i < size; ++i)
      if (std::isfinite((*row)[i])) {
        count[i] += 1;
        sum[i] += static_cast<double>((*row)[i]);
      }
  mean.assign(size, 0);
  for (std::size_t i = 0; i < size; ++i)
    if (count[i] > 0) mean[i] = static_cast<float>(std::clamp(sum[i] / count[i], -1e9, 1e9));
  for (const std::vector<float>* row : rows)
    for (std::size_t i = 0; i < size; ++i)
      if (std::isfinite((*row)[i])) {
        const double d = static_cast<double>((*row)[i]) - static_cast<double>(mean[i]);
        square[i] += d * d;
      }
  scale.assign(size, 0);
  for (std::size_t i = 0; i < size; ++i) {
    if (count[i] < 2) continue;
    const double variance = square[i] / count[i];
    const auto middle = static_cast<double>(mean[i]);
    if (variance > kVarianceMin * (middle * middle + 1e-8)) scale[i] = static_cast<float>(1 / std::sqrt(variance));
    if (!(scale[i] < 1e9F)) scale[i] = 0;
  }
  raw_.resize(size);
}

void FeatureScale::standardise(std::span<const float> feature, std::span<float> out) {
  index::standardise(feature.data(), mean.data(), scale.data(), static_cast<int>(feature.size()), raw_.data());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(StandardFeature::from_raw(raw_[i]).real());
}

TargetSpace::TargetSpace(const std::vector<Sample>& samples) {
  const auto subjects = one_of_each_subject(samples);
  const auto n = static_cast<double>(subjects.size());
  mean_.assign(kTargetMin, 0);
  scale_.assign(kTargetMin, 1);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(kTargetMin), square = sum;
  for (const Sample* s : subjects) sum += measured(*s);
  for (std::size_t t = 0; t < kTargetMin; ++t) mean_[t] = sum(static_cast<std::ptrdiff_t>(t)) / n;
  for (const Sample* s : subjects) square += measured(*s).cwiseAbs2();
  for (std::size_t t = 0; t < kTargetMin; ++t) {
    const double sd = std::sqrt(square(static_cast<std::ptrdiff_t>(t)) / n);
    scale_[t] = sd > 1e-6 * (std::abs(mean_[t]) + 1e-3) ? sd : 0.0;
  }
  learn_latents(subjects);
}

Eigen::VectorXd TargetSpace::measured(const MeasurementValues& truth, bool woman) const {
  Eigen::VectorXd y(kTargetMin);
  for (std::size_t t = 0; t < kTargetMin; ++t) {
    const double value = t < kMeasurementCount ? static_cast<double>(truth[t]) : (woman ? 1.0 : -1.0);
    y(static_cast<std::ptrdiff_t>(t)) = scale_[t] > 0 ? (value - mean_[t]) / scale_[t] : 0.0;
  }
  return y;
}

Eigen::VectorXd TargetSpace::deviation(const Sample& sample) const {
  Eigen::VectorXd x(body_mean_.size());
  for (std::ptrdiff_t j = 0; j < x.size(); ++j)
    x(j) = (static_cast<double>(sample.body[static_cast<std::size_t>(j)]) - body_mean_(j)) * body_inverse_sd_(j);
  return x;
}

// Directions of the body that measurements and sex leave open, strongest first, unit variance.
void TargetSpace::learn_latents(const std::vector<const Sample*>& subjects) {
  const auto n = static_cast<double>(subjects.size());
  const auto b = static_cast<std::ptrdiff_t>(subjects.front()->body.size());
  if (b == 0 || subjects.size() < kLatentSubjectsMin) return;
  body_mean_ = Eigen::VectorXd::Zero(b);
  body_inverse_sd_ = Eigen::VectorXd::Ones(b);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(b);
  Eigen::VectorXd sum = zero, square = zero;
  for (const Sample* s : subjects) sum += deviation(*s);
  body_mean_ = sum / n;
  for (const Sample* s : subjects) square += deviation(*s).cwiseAbs2();
  for (std::ptrdiff_t j = 0; j < b; ++j) {
    const double sd = std::sqrt(square(j) / n);
    body_inverse_sd_(j) = sd > 1e-6 ? 1 / sd : 0.0;
  }
  Eigen::MatrixXd yy = Eigen::MatrixXd::Zero(kTargetMin, kTargetMin), yx = Eigen::MatrixXd::Zero(kTargetMin, b);
  for (const Sample* s : subjects) {
    const Eigen::VectorXd y = measured(*s);
    yy += y * y.transpose();
    yx += y * deviation(*s).transpose();
  }
  yy.diagonal().array() += 1e-3 * n;
  body_by_measured_ = lab::solve_positive(yy, yx).transpose();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(b, b);
  for (const Sample* s : subjects) {
    const Eigen::VectorXd x = deviation(*s) - body_by_measured_ * measured(*s);
    covariance += x / n * x.transpose();
  }
  const lab::SymmetricEigen eigen = lab::symmetric_eigen(covariance);
  const std::ptrdiff_t count = std::min<std::ptrdiff_t>(b, kLatentMax);
  latent_.resize(b, count);
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    // The sign of an eigenvector is the solver's whim: fix it by the largest coefficient.
    Eigen::VectorXd v = eigen.vectors.col(b - 1 - k);
    std::ptrdiff_t largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    if (v(largest) < 0) v = -v;
    latent_.col(k) = v / std::sqrt(std::max(eigen.values(b - 1 - k), 1e-12));
    mean_.push_back(0);
    scale_.push_back(1);
  }
}

Eigen::VectorXd TargetSpace::operator()(const Sample& sample) const {
  const Eigen::VectorXd y = measured(sample);
  Eigen::VectorXd out(size());
  out.head(kTargetMin) = y;
  if (latent_.cols() > 0)
    out.tail(latent_.cols()) = latent_.transpose() * (deviation(sample) - body_by_measured_ * y);
  return out.unaryExpr([](double v) { return rounded_target(v); });
}

void TargetSpace::keep(const std::vector<std::ptrdiff_t>& targets) {
  Eigen::MatrixXd kept(latent_.rows(), static_cast<std::ptrdiff_t>(targets.size()) - kTargetMin);
  for (std::ptrdiff_t k = 0; k < kept.cols(); ++k)
    kept.col(k) = latent_.col(targets[static_cast<std::size_t>(k + kTargetMin)] - kTargetMin);
  latent_ = kept;
  mean_.resize(targets.size());  // latents all have mean 0 and scale 1
  scale_.resize(targets.size());
}

int FoldDealer::fold_of(std::uint64_t subject) {
  if (dealt_ > 0 && subject == last_) return fold_;
  const std::uint64_t round = dealt_ / order_.size();
  const auto place = static_cast<std::size_t>(dealt_ % order_.size());
  if (place == 0) {
    std::iota(order_.begin(), order_.end(), 0);
    Rng rng = Rng::for_item(seed_, 0x1dec5, round);
    for (std::size_t i = order_.size() - 1; i > 0; --i)
      std::swap(order_[i], order_[static_cast<std::size_t>(rng.index(static_cast<int>(i + 1)))]);
  }
  ++dealt_;
  last_ = subject;
  return fold_ = order_[place];
}

}  // namespace im2fit::index
