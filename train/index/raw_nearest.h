// SPDX-License-Identifier: Apache-2.0
// The paper's answer, for comparison: the nearest model by plain Euclidean distance of its raw 501 features.
// Workstation code.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "train/index/sample.h"

namespace im2fit::index {

class RawNearest {
 public:
  // Only the first `feature_size` values of every feature are compared.
  explicit RawNearest(std::size_t feature_size = 501) : feature_size_(feature_size) {}
  // Samples with shorter features, and those that only calibrate, are refused (false).
  bool add(const Sample& sample);
  std::size_t size() const { return truth_.size(); }

  struct Match {
    std::uint32_t sample = 0;  // in the order of adding
    double distance = 0;       // root mean square over the values measured in both, times sqrt(feature_size)
    MeasurementValues values{};
    bool woman = false;
  };
  // Exhaustive. Values that are NaN in either feature are left out. Ties go to the sample added first. At least one
  // sample must have been added, and `feature` must not be shorter than feature_size.
  Match nearest(std::span<const float> feature) const;

 private:
  std::size_t feature_size_;
  std::vector<float> features_;
  std::vector<MeasurementValues> truth_;
  std::vector<bool> woman_;
};

}  // namespace im2fit::index
