// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_votes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

using joints::kLeafCount;
using joints::kSplitCount;
using joints::Split;

constexpr int kCandidateCount = 120;
constexpr int kExaminedMax = 1500;
constexpr double kShrinkage = 0.15;
constexpr double kLeafPrior = 4;  // of the Hessian
constexpr double kStepMax = 2;    // log-odds a leaf may add before shrinkage

// Sums of the examples' derivatives on either side of each candidate's threshold.
struct Side {
  std::array<float, kCandidateCount> slope{}, bend{};
};
struct Sides {
  Side low, high;
};

// `row`: an example's values.
IM2FIT_SIMD_CLONES void add_to_sides(const std::array<Split, kCandidateCount>& candidates, const std::int16_t* row,
                                     float slope, float bend, Sides& sides) {
  std::array<std::int32_t, kCandidateCount> is_high;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Split& s = candidates[c];
    is_high[c] = (s.threshold - (row[s.a] - row[s.b])) >> 31 & 1;  // no branch
  }
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const auto high = static_cast<float>(is_high[c]), low = 1 - high;
    sides.high.slope[c] += high * slope;
    sides.high.bend[c] += high * bend;
    sides.low.slope[c] += low * slope;
    sides.low.bend[c] += low * bend;
  }
}

class VoteTrainer {
 public:
  VoteTrainer(VoteExamples examples, const DrawPair& draw_pair, Rng rng)
      : examples_(std::move(examples)), draw_pair_(draw_pair), rng_(rng) {
    score_.resize(examples_.size());
    slope_.resize(examples_.size());
    bend_.resize(examples_.size());
  }

  void add_tree(VoteTrees& out) {
    for (std::size_t i = 0; i < examples_.size(); ++i) {
      const double p = 1 / (1 + std::exp(-static_cast<double>(score_[i]) / joints::kVoteUnit));
      slope_[i] = static_cast<float>(examples_.yes[i] - p);
      bend_[i] = static_cast<float>(std::max(p * (1 - p), 1e-6));
    }
    std::vector<std::int32_t> order(examples_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
    std::array<std::size_t, kSplitCount + kLeafCount> first{}, last{};
    last[0] = order.size();
    for (std::size_t node = 0; node < first.size(); ++node) {
      const std::span<std::int32_t> mine(order.data() + first[node], last[node] - first[node]);
      if (node >= static_cast<std::size_t>(kSplitCount)) {
        out.leaves.push_back(leaf(mine));
        for (const std::int32_t i : mine) score_[static_cast<std::size_t>(i)] += out.leaves.back();
        continue;
      }
      const Split s = choose(mine);
      out.splits.push_back(s);
      const auto middle = std::stable_partition(mine.begin(), mine.end(),
                                                [&](std::int32_t i) { return difference(i, s) <= s.threshold; });
      const std::size_t cut = first[node] + static_cast<std::size_t>(middle - mine.begin());
      first[2 * node + 1] = first[node];
      last[2 * node + 1] = first[2 * node + 2] = cut;
      last[2 * node + 2] = last[node];
    }
  }

 private:
  const std::int16_t* row(std::int32_t i) const {
    return examples_.values.data() + static_cast<std::ptrdiff_t>(i) * examples_.value_count;
  }
  int difference(std::int32_t i, const Split& s) const { return row(i)[s.a] - row(i)[s.b]; }

  Split choose(std::span<const std::int32_t> mine) {
    Split best;
    best.b = 1;
    if (mine.size() < 20) return best;
    const std::size_t stride = std::max<std::size_t>(1, mine.size() / kExaminedMax);
    std::array<Split, kCandidateCount> candidates;
    std::size_t count = 0;
    for (int c = 0; c < kCandidateCount; ++c) {
      Split s = draw_pair_(rng_);
      if (s.a == s.b) continue;
      const std::int32_t like = mine[static_cast<std::size_t>(rng_.index(static_cast<int>(mine.size())))];
      s.threshold = static_cast<std::int16_t>(difference(like, s) + static_cast<int>(rng_.normal(0, 10)));
      candidates[count++] = s;
    }
    // Example by example, so that its row is read from memory once for all candidates.
    Sides sides;
    for (std::size_t n = 0; n < mine.size(); n += stride)
      add_to_sides(candidates, row(mine[n]), slope_[static_cast<std::size_t>(mine[n])],
                   bend_[static_cast<std::size_t>(mine[n])], sides);
    const auto gain_of = [](const Side& side, std::size_t c) {
      return side.slope[c] * side.slope[c] / (side.bend[c] + static_cast<float>(kLeafPrior));
    };
    float best_gain = -1;
    for (std::size_t c = 0; c < count; ++c) {
      const float gain = gain_of(sides.low, c) + gain_of(sides.high, c);
      if (gain <= best_gain) continue;
      best_gain = gain;
      best = candidates[c];
    }
    return best;
  }

  // Newton's step.
  std::int16_t leaf(std::span<const std::int32_t> mine) const {
    double slope = 0, bend = kLeafPrior;
    for (const std::int32_t i : mine) {
      slope += static_cast<double>(slope_[static_cast<std::size_t>(i)]);
      bend += static_cast<double>(bend_[static_cast<std::size_t>(i)]);
    }
    const double step = kShrinkage * std::clamp(slope / bend, -kStepMax, kStepMax);
    return static_cast<std::int16_t>(std::lround(step * joints::kVoteUnit));
  }

  VoteExamples examples_;
  const DrawPair& draw_pair_;
  Rng rng_;
  std::vector<int> score_;
  std::vector<float> slope_, bend_;  // first and second derivative of the log-likelihood
};

}  // namespace

void train_votes(VoteExamples examples, int tree_count, const DrawPair& draw_pair, Rng rng, VoteTrees& out) {
  VoteTrainer trainer(std::move(examples), draw_pair, rng);
  for (int t = 0; t < tree_count; ++t) trainer.add_tree(out);
}

}  // namespace im2fit::lab
