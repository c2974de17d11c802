// SPDX-License-Identifier: Apache-2.0
// Workstation side: learns the refinements from the samples that have a fit and a view from behind.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/container.h"
#include "index/clothing_estimate.h"
#include "index/refinement.h"
#include "train/index/calibration.h"
#include "train/index/learning.h"
#include "train/index/refinement_table.h"
#include "train/index/sample.h"

namespace im2fit::index {

class RefinementBuilder {
 public:
  static constexpr std::size_t kSampleMin = kRefinementSampleMin;
  // Held in memory, of people undressed and in clothes: 18 kB each, and as much again while they are learned from, by
  // each thread.
  static constexpr std::size_t kSampleMax = 16384;
  // Keeps the needed parts of a sample that refines.
  void add(const Sample& sample);
  // The index' plain answers, standardised, to the first capture of subjects that had no part in them.
  using PlainAnswers = std::map<std::uint64_t, Targets>;
  struct Settings {
    std::uint64_t seed = 1;
    std::uint32_t shape_key = 0;
    bool for_unknown_makes = true;  // intervals are wider by kUnknownMakeWidening
    int threads = 1;                // the result does not depend on them
  };
  // `targets`: as the index standardises them. A kind of people with fewer than kSampleMin samples is left out. Gives
  // up what add() kept.
  void learn(const TargetSpace& targets, const PlainAnswers& plain, const Settings& settings);
  // Sections of every refinement that was learned, and of the clothing classifier.
  void write(ContainerWriter& out) const;

 private:
  struct Row {
    std::uint64_t subject = 0;
    // Of the front, and of the side with fewer or that is farther.
    std::array<int, 2> frame_count{}, distance_mm{};
    bool ood = false;
    bool woman = false;
    std::uint8_t clothes_kind = 0;
    MeasurementValues truth{};
    std::array<std::vector<float>, 2> values;  // of the front, and of both sides
  };
  using Rows = std::vector<Row>;
  // What a ValueMap is made of.
  struct LearnedMap {
    std::vector<std::uint16_t> mean, scale;
    RoundedWeights weights;
    std::vector<float> bias;
    LearnedMap() = default;
    LearnedMap(const FeatureScale& values, const LinearFit& fit);
  };
  struct Learned {
    RefinementRecord record;
    LearnedMap map;
    std::vector<float> interval, spread_floor, sex_table;
    // Of each of the people: the truth and what regressions that were not trained on them answered, standardised;
    // how new to the regression they look (ValueMap::novelty), where clothes are worn.
    struct Answers {
      Eigen::MatrixXd truth, answered;
      // By regressions that met no clothes of the person's kind either; `met_none`: for whom there is one.
      Eigen::MatrixXd of_unknown_clothes;
      std::vector<bool> met_none;
      std::vector<double> novelty;
    };
    // Intervals from the rows `judged`, shares from the rows `unlike` (out-of-distribution subjects, where there are
    // enough).
    void judge(Refinement kind, const Rows& people, const std::vector<std::ptrdiff_t>& judged,
               const std::vector<std::ptrdiff_t>& unlike, const TargetSpace& targets, const PlainAnswers& plain,
               const Answers& answers, bool for_unknown_makes);
    HeldOut held_out_of(Refinement kind, const Row& row, const Answers& answers, std::ptrdiff_t at,
                        const Eigen::MatrixXd& answered, const PlainAnswers& plain) const;
  };
  Learned learn_one(Refinement kind, const Rows& rows, const TargetSpace& targets, const PlainAnswers& plain,
                    const Settings& settings) const;

  struct LearnedClothing {
    ClothingRecord record;
    LearnedMap map;
    std::vector<float> table;
  };
  LearnedClothing learn_clothing(Refinement view, std::uint64_t seed) const;

  std::array<Rows, 2> rows_;  // of people undressed, and in clothes
  std::size_t feature_size_ = 0;
  FitLayout fit_;
  std::array<std::optional<Learned>, kRefinementCount> learned_;
  std::array<std::optional<LearnedClothing>, kClothingViews.size()> clothing_;  // as kClothingViews
};

}  // namespace im2fit::index
