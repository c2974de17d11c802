// SPDX-License-Identifier: Apache-2.0
#include "train/index/raw_nearest.h"

#include <cmath>
#include <limits>

namespace im2fit::index {

bool RawNearest::add(const Sample& sample) {
  if (!sample.is_entry() || sample.feature.size() < feature_size_) return false;
  features_.insert(features_.end(), sample.feature.begin(),
                   sample.feature.begin() + static_cast<std::ptrdiff_t>(feature_size_));
  truth_.push_back(sample.truth);
  woman_.push_back(sample.woman);
  return true;
}

RawNearest::Match RawNearest::nearest(std::span<const float> feature) const {
  Match best;
  double best_square = std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < truth_.size(); ++s) {
    const float* x = features_.data() + s * feature_size_;
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < feature_size_; ++i) {
      const float d = x[i] - feature[i];
      if (std::isnan(d)) continue;
      sum += static_cast<double>(d) * static_cast<double>(d);
      ++count;
    }
    const double square = count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::max();
    if (square < best_square) {
      best_square = square;
      best.sample = static_cast<std::uint32_t>(s);
    }
  }
  best.distance = std::sqrt(best_square * static_cast<double>(feature_size_));
  if (!truth_.empty()) {
    best.values = truth_[best.sample];
    best.woman = woman_[best.sample];
  }
  return best;
}

}  // namespace im2fit::index
