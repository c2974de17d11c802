// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_votes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

namespace im2fit::lab {
namespace {

constexpr int kValues = 8;

DrawPair any_pair() {
  return [](Rng& rng) {
    joints::Split s;
    s.a = static_cast<std::uint16_t>(rng.index(kValues));
    s.b = static_cast<std::uint16_t>(rng.index(kValues));
    return s;
  };
}

// Yes where value 2 exceeds value 5 by more than 30, but for one in ten.
VoteExamples drawn(std::uint64_t seed, int count) {
  Rng rng(seed);
  VoteExamples out;
  out.value_count = kValues;
  for (int i = 0; i < count; ++i) {
    const std::size_t first = out.values.size();
    for (int k = 0; k < kValues; ++k) out.values.push_back(static_cast<std::int16_t>(rng.index(400) - 200));
    const bool yes = out.values[first + 2] - out.values[first + 5] > 30;
    out.yes.push_back((rng.index(10) == 0) != yes ? 1 : 0);
  }
  return out;
}

double log_odds(const VoteTrees& trees, const VoteExamples& examples, std::size_t i) {
  return joints::count_votes(trees.view(), examples.values.data() + i * kValues) /
         static_cast<double>(joints::kVoteUnit);
}

TEST(TrackerVotes, ARuleIsLearntWithItsChance) {
  VoteTrees trees;
  train_votes(drawn(1, 6000), 60, any_pair(), Rng(2), trees);
  EXPECT_EQ(trees.tree_count(), 60U);
  const VoteExamples unseen = drawn(3, 3000);
  double stated = 0;
  int right = 0, clear = 0;
  for (std::size_t i = 0; i < unseen.size(); ++i) {
    const std::int16_t* v = unseen.values.data() + i * kValues;
    const int beyond = v[2] - v[5] - 30;
    if (std::abs(beyond) < 20) continue;
    const double odds = log_odds(trees, unseen, i);
    ++clear;
    right += (odds > 0) == (beyond > 0) ? 1 : 0;
    stated += std::fabs(odds);
  }
  EXPECT_GT(right, 0.98 * clear);
  EXPECT_NEAR(stated / clear, std::log(9), 0.6) << "nine in ten";
}

}  // namespace
}  // namespace im2fit::lab
