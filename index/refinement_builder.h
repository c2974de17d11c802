// SPDX-License-Identifier: Apache-2.0
// Workstation side: learns both refinements from the samples that have a fit and a view from behind.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "base/container.h"
#include "index/calibration.h"
#include "index/learning.h"
#include "index/refinement.h"
#include "index/sample.h"

namespace im2fit::index {

class RefinementBuilder {
 public:
  static constexpr std::size_t kSampleMin = 150;    // fewer teach too little
  static constexpr std::size_t kSampleMax = 16384;  // held in memory: 10 kB each
  // Keeps what it needs of a sample that refines.
  void add(const Sample& sample);
  std::size_t sample_count() const { return rows_.size(); }
  // The index' plain answers, standardised, to subjects that had no part in them.
  using PlainAnswers = std::map<std::uint64_t, Targets>;
  // `targets`: as the index standardises them. Does nothing with fewer than kSampleMin samples.
  void learn(const TargetSpace& targets, const PlainAnswers& plain, std::uint64_t seed, std::uint32_t shape_key);
  // Sections "fitted.*" and "turned.*"; none when nothing was learned.
  void write(ContainerWriter& out) const;

 private:
  struct Row {
    std::uint64_t subject = 0;
    int frame_count = 1;
    bool stranger = false;
    bool woman = false;
    MeasurementValues truth{};
    std::array<std::vector<float>, kRefinementCount> values;
  };
  struct Learned {
    RefinementRecord record;
    std::vector<float> mean, scale;
    std::vector<std::int16_t> weights;
    std::vector<float> unit, bias, interval, spread_floor, sex_table;
  };
  std::vector<std::ptrdiff_t> all_strangers() const;
  Learned learn_one(Refinement kind, const TargetSpace& targets, const PlainAnswers& plain, std::uint64_t seed) const;

  std::vector<Row> rows_;
  std::size_t fit_size_ = 0;
  std::array<std::optional<Learned>, kRefinementCount> learned_;
};

}  // namespace im2fit::index
