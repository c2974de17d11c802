// SPDX-License-Identifier: Apache-2.0
// From regressed targets to an answer: quadratic and local correction, intervals, sex, nearest entry.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "index/format.h"
#include "index/index.h"

namespace im2fit::index {

class Answerer {
 public:
  // Rounds the regression to integers. The contents' bytes must outlive this.
  explicit Answerer(const Contents& contents);
  // Memory for the queries of one thread.
  struct Workspace {
    explicit Workspace(const Answerer& answerer);
    std::vector<std::int16_t> standardised;
    CodeSearch search;
    std::array<std::optional<ValueMap::Work>, kRefinementCount> refining;
    std::array<std::optional<ValueMap::Work>, kClothingViews.size()> clothing;
  };
  // A feature of the wrong size counts as not measured.
  Targets regressed(std::span<const float> feature, Workspace& work) const;
  // The best answer that `seen` allows: turned, fitted, or from the front's feature alone. For dressed people it uses
  // the refinements for clothes, where the index has them. If clothing is to be estimated, it mixes both answers by
  // the probability of clothes. Errors: the part of the file that is read is damaged.
  Result<Answer> answer(const Seen& seen, const QueryOptions& options, Workspace& work) const;

  // The nearest of all entries, `count` or kNeighbourMax of them.
  Result<std::span<const Neighbour>> alike(const Seen& seen, std::size_t count, Workspace& work) const;

  // Regressed targets with both corrections. Standardised units.
  struct Corrected {
    Targets value{};
    Targets spread{};                       // of the residuals nearby
    Position shift{};                       // of the place, by the surface
    std::span<const Neighbour> neighbours;  // that were used; valid until the workspace's next search
  };
  Result<Corrected> corrected(const Targets& regressed, const QueryOptions& options, Workspace& work) const;

 private:
  const Refiner* refiner_for(const Seen& seen, bool dressed) const;
  Result<Answer> answer_as(bool dressed, const Seen& seen, const QueryOptions& options, Workspace& work) const;
  // Of both sides where they are seen; null: the index has none, or too little is seen.
  const ClothingEstimator* clothing_estimator_for(const Seen& seen, std::size_t& view) const;
  // Where in the projected space neighbours are searched: at the refined answer for people in clothes.
  Targets position_targets_of(const Seen& seen, const Refiner* refiner, Workspace& work) const;
  Coordinates grid_of(const Targets& targets) const;
  Position place_of(const Targets& targets) const;
  void fill_nearest(const Corrected& corrected, Answer& out) const;
  // The error model of answers, from the file, for one estimator (plain or a refinement).
  struct Uncertainty {
    NoiseModel noise;
    bool local;
    std::span<const float> interval, spread_floor, sex_table;
    double novelty = 0;  // of clothes (index/noise_model.h)
  };
  void fill_estimates(const Targets& targets, const Targets& spread, const Uncertainty& uncertainty,
                      const QueryOptions& options, Answer& out) const;

  Contents contents_;
  Regressor regressor_;
  std::array<std::optional<Refiner>, kRefinementCount> refiners_;
  std::array<std::optional<ClothingEstimator>, kClothingViews.size()> clothing_estimators_;
};

}  // namespace im2fit::index
