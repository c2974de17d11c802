// SPDX-License-Identifier: Apache-2.0
// Learning votes of two kinds (back or front, person or thing): boosted trees with logistic loss (Friedman 2001)
// on differences of two values.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/rng.h"
#include "perception/joints/model_data.h"

namespace im2fit::lab {

struct VoteTrees {
  std::vector<joints::Anchor> anchors;
  std::vector<joints::Split> splits;
  std::vector<std::int16_t> leaves;
  std::size_t tree_count() const { return splits.size() / static_cast<std::size_t>(joints::kSplitCount); }
  joints::Votes view() const { return {anchors, splits, leaves}; }
};

struct VoteExamples {
  std::vector<std::int16_t> values;  // examples * value_count
  int value_count = 0;
  std::vector<std::uint8_t> yes;  // by example
  std::size_t size() const { return yes.size(); }
};

// Which two values a split compares: a and b of the answer.
using DrawPair = std::function<joints::Split(Rng&)>;

// Appends `tree_count` trees to `out`.
void train_votes(VoteExamples examples, int tree_count, const DrawPair& draw_pair, Rng rng, VoteTrees& out);

}  // namespace im2fit::lab
