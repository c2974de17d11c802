// SPDX-License-Identifier: Apache-2.0
#include "bench/index/models.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace im2fit::bench {
namespace {

std::size_t sex_of(const index::Sample& sample) {
  return sample.woman ? 1 : 0;
}

float product(std::span<const float> a, std::span<const float> b) {
  std::array<float, 8> sum{};
  std::size_t i = 0;
  for (; i + sum.size() <= a.size(); i += sum.size())
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += a[i + k] * b[i + k];
  float total = 0;
  for (; i < a.size(); ++i) total += a[i] * b[i];
  for (const float s : sum) total += s;
  return total;
}

double distance_square(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
    sum += d * d;
  }
  return sum;
}

}  // namespace

Models::Models(std::span<const index::Sample> real, std::size_t size, std::uint64_t seed, std::size_t width)
    : real_(real.first(std::min(real.size(), size))), size_(size), width_(width), deviations_(real_.size() * width) {
  std::array<std::vector<double>, 3> sum, count;  // the last of all
  for (std::size_t s = 0; s < 3; ++s) {
    sum[s].assign(width_, 0);
    count[s].assign(width_, 0);
  }
  std::array<std::vector<std::uint32_t>, 2> of_sex;
  std::array<std::array<double, kMeasurementCount>, 2> truth_sum{};
  for (std::size_t n = 0; n < real_.size(); ++n) {
    const std::size_t sex = sex_of(real_[n]);
    of_sex[sex].push_back(static_cast<std::uint32_t>(n));
    for (std::size_t m = 0; m < kMeasurementCount; ++m) truth_sum[sex][m] += static_cast<double>(real_[n].truth[m]);
    for (std::size_t i = 0; i < width_; ++i) {
      if (std::isnan(real_[n].feature[i])) continue;
      for (const std::size_t s : {sex, std::size_t{2}}) {
        sum[s][i] += static_cast<double>(real_[n].feature[i]);
        count[s][i] += 1;
      }
    }
  }
  const auto mean = [&](std::size_t s) {
    std::vector<float> out;
    for (std::size_t i = 0; i < width_; ++i)
      out.push_back(static_cast<float>(sum[s][i] / std::max(count[s][i], 1.0)));
    return out;
  };
  for (std::size_t sex = 0; sex < 2; ++sex) {
    mean_[sex] = mean(sex);
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      truth_mean_[sex][m] =
          static_cast<float>(truth_sum[sex][m] / std::max(static_cast<double>(of_sex[sex].size()), 1.0));
  }
  mean_of_all_ = mean(2);
  for (std::size_t n = 0; n < real_.size(); ++n)
    for (std::size_t i = 0; i < width_; ++i) {
      const float d = real_[n].feature[i] - mean_[sex_of(real_[n])][i];
      deviations_[n * width_ + i] = std::isnan(d) ? 0 : d;
    }
  const index::Densifier densifier(std::move(of_sex), seed);
  recipes_.reserve(size_);
  for (std::uint32_t n = 0; n < real_.size(); ++n) recipes_.push_back({n, n, 1, 0});
  for (std::uint64_t n = 0; recipes_.size() < size_; ++n) {
    const index::Mix mix = densifier.mix(n);
    recipes_.push_back(
        {mix.first, mix.second, static_cast<float>(mix.first_share), static_cast<float>(mix.second_share)});
  }
}

void Models::feature(std::size_t model, float* out) const {
  const Recipe& r = recipes_[model];
  const float* mean = mean_[sex_of(real_[r.first])].data();
  const float* a = deviation(r.first).data();
  const float* b = deviation(r.second).data();
  for (std::size_t i = 0; i < width_; ++i) out[i] = mean[i] + r.first_share * a[i] + r.second_share * b[i];
}

MeasurementValues Models::truth(std::size_t model) const {
  const Recipe& r = recipes_[model];
  const MeasurementValues& mean = truth_mean_[sex_of(real_[r.first])];
  MeasurementValues out{};
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    out[m] = mean[m] + r.first_share * (real_[r.first].truth[m] - mean[m]) +
             r.second_share * (real_[r.second].truth[m] - mean[m]);
  return out;
}

std::vector<float> Models::query(std::span<const float> feature) const {
  std::vector<float> out(feature.begin(), feature.begin() + width_);
  for (std::size_t i = 0; i < width_; ++i)
    if (std::isnan(out[i])) out[i] = mean_of_all_[i];
  return out;
}

double Models::each_block(std::size_t rows,
                          const std::function<void(std::size_t first, std::span<const float> features)>& take) const {
  using Clock = std::chrono::steady_clock;
  Clock::duration spent{};
  std::vector<float> block(std::min(rows, size_) * width_);
  for (std::size_t first = 0; first < size_; first += rows) {
    const std::size_t count = std::min(rows, size_ - first);
    const auto start = Clock::now();
    for (std::size_t k = 0; k < count; ++k) feature(first + k, &block[k * width_]);
    spent += Clock::now() - start;
    take(first, std::span(block).first(count * width_));
  }
  return std::chrono::duration<double>(spent).count();
}

std::vector<float> Models::some(std::size_t count) const {
  count = std::min(count, size_);
  std::vector<float> out(count * width_);
  for (std::size_t k = 0; k < count; ++k) feature(k * size_ / count, &out[k * width_]);
  return out;
}

ExactNearest::ExactNearest(const Models& models) : models_(models) {
  square_.reserve(models.size());
  for (std::size_t n = 0; n < models.size(); ++n) {
    const auto& r = models.recipes_[n];
    const auto a = models.deviation(r.first), b = models.deviation(r.second);
    float square = r.first_share * r.first_share * product(a, a);
    if (r.second_share > 0)
      square += r.second_share * (2 * r.first_share * product(a, b) + r.second_share * product(b, b));
    square_.push_back(square);
  }
}

std::vector<std::uint32_t> ExactNearest::nearest(std::span<const float> query, std::size_t count) const {
  // |q - mean - x|^2 less |q|^2 of the query about each sex's mean; the few best are then compared exactly.
  const std::size_t kept = count + 8;
  std::array<std::vector<float>, 2> centred;
  std::array<float, 2> offset{};
  for (std::size_t s = 0; s < 2; ++s) {
    for (std::size_t i = 0; i < models_.width(); ++i) centred[s].push_back(query[i] - models_.mean_[s][i]);
    offset[s] = product(centred[s], centred[s]);
  }
  std::vector<float> products;
  for (std::size_t n = 0; n < models_.real_count(); ++n)
    products.push_back(product(models_.deviation(n), centred[sex_of(models_.real_[n])]));
  std::vector<std::pair<float, std::uint32_t>> best;
  float worst = 0;
  for (std::size_t n = 0; n < models_.size(); ++n) {
    const auto& r = models_.recipes_[n];
    const float d = offset[sex_of(models_.real_[r.first])] + square_[n] -
                    2 * (r.first_share * products[r.first] + r.second_share * products[r.second]);
    if (best.size() == kept && d >= worst) continue;
    if (best.size() == kept) best.pop_back();
    best.insert(std::upper_bound(best.begin(), best.end(), std::pair{d, static_cast<std::uint32_t>(n)}),
                {d, static_cast<std::uint32_t>(n)});
    worst = best.back().first;
  }
  std::vector<std::pair<double, std::uint32_t>> exact;
  std::vector<float> x(models_.width());
  for (const auto& [d, n] : best) {
    models_.feature(n, x.data());
    exact.push_back({distance_square(query, x), n});
  }
  std::sort(exact.begin(), exact.end());
  std::vector<std::uint32_t> out;
  for (std::size_t k = 0; k < std::min(count, exact.size()); ++k) out.push_back(exact[k].second);
  return out;
}

}  // namespace im2fit::bench
