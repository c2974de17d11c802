// SPDX-License-Identifier: Apache-2.0
// From regressed targets to an answer: quadratic and local correction, intervals, sex, nearest stored body.
#pragma once

#include <span>

#include "index/format.h"
#include "index/index.h"

namespace im2fit::index {

class Answerer {
 public:
  // Builds both kd-trees and the integer regression. The contents' bytes must outlive this.
  explicit Answerer(const Contents& contents);
  // What one thread's query needs.
  struct Workspace {
    explicit Workspace(const Answerer& answerer);
    std::vector<std::int16_t> standardised;
    CodeSearch points, entries;
    LocalWeights local;
  };
  // A feature of the wrong size counts as not measured.
  Targets regressed(std::span<const float> feature, Workspace& work) const;
  Answer answer(const Targets& regressed, const QueryOptions& options, Workspace& work) const;

  // Body parameters at the answered targets: local linear regression of the stored bodies on their true positions.
  // `out`: body_size values.
  void body(const Targets& regressed, const QueryOptions& options, Workspace& work, std::span<float> out) const;

  // Regressed targets with both corrections; `spread`: of the residuals nearby. Standardised units.
  Targets corrected(const Targets& regressed, const QueryOptions& options, Workspace& work, Targets& spread) const;

 private:
  Coordinates key_of(const Targets& targets) const;
  void fill_estimates(const Targets& targets, const Targets& spread, int frame_count, Answer& out) const;
  float female_probability(double score) const;

  Contents contents_;
  Regressor regressor_;
  CodeTree points_;   // captures, where the regression puts them: for the local correction
  CodeTree entries_;  // subjects, where their true measurements put them: for the body
};

}  // namespace im2fit::index
