// SPDX-License-Identifier: Apache-2.0
// The same models for everyone: their raw features and true measurements, any number of them in little memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "train/index/densify.h"
#include "train/index/sample.h"

namespace im2fit::bench {

inline constexpr std::size_t kRawSize = 501;  // the paper's feature: 4 lengths, 2 ratios, 15 FPFH

// The first `size` of the real models; from where they end, mixes of them (train/index/densify.h), the very
// mixes that build_index makes for the same seed. A feature that was not measured counts as its sex's mean.
class Models {
 public:
  // Features are cut after `width` values.
  Models(std::span<const index::Sample> real, std::size_t size, std::uint64_t seed, std::size_t width = kRawSize);

  std::size_t size() const { return size_; }
  std::size_t width() const { return width_; }
  std::size_t real_count() const { return real_.size(); }
  std::size_t densified_count() const { return size_ - real_.size(); }
  std::span<const index::Sample> real() const { return real_; }

  void feature(std::size_t model, float* out) const;  // width() values
  MeasurementValues truth(std::size_t model) const;
  // Of a query: a value that was not measured counts as the mean of all.
  std::vector<float> query(std::span<const float> feature) const;
  // All features in order, `rows` at a time. The time it took, which counts as no build time, in s.
  double each_block(std::size_t rows,
                    const std::function<void(std::size_t first, std::span<const float> features)>& take) const;
  // Every (size / count)-th feature.
  std::vector<float> some(std::size_t count) const;

 private:
  friend class ExactNearest;
  struct Recipe {
    std::uint32_t first = 0, second = 0;
    float first_share = 1, second_share = 0;
  };
  std::span<const float> deviation(std::size_t real) const { return {&deviations_[real * width_], width_}; }

  std::span<const index::Sample> real_;
  std::size_t size_, width_;
  std::array<std::vector<float>, 2> mean_;  // of a sex
  std::vector<float> mean_of_all_;
  std::array<MeasurementValues, 2> truth_mean_{};
  std::vector<float> deviations_;  // real features less their sex's mean
  std::vector<Recipe> recipes_;
};

// The nearest model by the raw features, exactly, at any size: of a mix, square and product with a query are sums of
// those of its two parts, so that no raw features need to be held. What others' recall is counted by, and what brute
// force answers where it does not fit.
class ExactNearest {
 public:
  explicit ExactNearest(const Models& models);
  // Nearest first; min(count, models).
  std::vector<std::uint32_t> nearest(std::span<const float> query, std::size_t count) const;

 private:
  const Models& models_;
  std::vector<float> square_;  // of every model, about its sex's mean
};

}  // namespace im2fit::bench
