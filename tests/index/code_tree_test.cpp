// SPDX-License-Identifier: Apache-2.0
#include "index/code_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/rng.h"

namespace im2fit::index {
namespace {

std::vector<Neighbour> exhaustive(const std::vector<std::int8_t>& codes, const Coordinates& steps,
                                  const Coordinates& q, std::size_t count) {
  std::vector<Neighbour> all;
  for (std::size_t i = 0; i < codes.size() / kDimensionMax; ++i) {
    std::int64_t sum = 0;
    for (std::size_t j = 0; j < kDimensionMax; ++j) {
      const std::int64_t d = static_cast<std::int64_t>(codes[i * kDimensionMax + j]) * steps[j] - q[j];
      sum += d * d;
    }
    all.push_back({sum, static_cast<std::uint32_t>(i)});
  }
  std::sort(all.begin(), all.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::pair(a.distance, a.index) < std::pair(b.distance, b.index);
  });
  all.resize(std::min(count, all.size()));
  return all;
}

// `coarse`: few distinct codes, so that ties abound.
void compare(std::size_t points, int dimensions, bool coarse, std::uint64_t seed) {
  Rng rng(seed);
  Coordinates steps{};
  for (int j = 0; j < dimensions; ++j) steps[static_cast<std::size_t>(j)] = 1 + rng.index(kStepMax);
  std::vector<std::int8_t> codes(points * kDimensionMax);
  for (std::size_t i = 0; i < points; ++i)
    for (int j = 0; j < dimensions; ++j)
      codes[i * kDimensionMax + static_cast<std::size_t>(j)] =
          static_cast<std::int8_t>(coarse ? rng.index(3) : rng.index(256) - 128);
  const CodeTree tree(codes, steps);
  CodeSearch search(tree);
  for (int trial = 0; trial < 20; ++trial) {
    Coordinates q{};
    const int reach = trial % 4 == 3 ? kCoordinateMax : 1 << 16;
    for (auto& c : q) c = rng.index(2 * reach) - reach;
    if (trial == 0)
      for (std::size_t j = 0; j < q.size(); ++j) q[j] = codes[j] * steps[j];
    for (const std::size_t k : {std::size_t{1}, std::size_t{7}, std::size_t{kNeighbourMax}}) {
      const auto found = search.nearest(q, k);
      const auto truth = exhaustive(codes, steps, q, k);
      ASSERT_TRUE(std::equal(found.begin(), found.end(), truth.begin(), truth.end()))
          << points << " points, " << dimensions << " dimensions, k " << k << ", coarse " << coarse;
    }
  }
}

TEST(CodeTree, FindsWhatAnExhaustiveScanFinds) {
  compare(1, 4, false, 1);
  compare(23, 1, false, 2);
  compare(3000, 5, false, 3);
  compare(3000, 16, false, 4);
}

TEST(CodeTree, TiesGoToTheSmallerIndex) {
  compare(2000, 3, true, 5);
  compare(700, 1, true, 6);
}

TEST(CodeTree, AllPointsAlike) {
  const std::vector<std::int8_t> codes(5000 * kDimensionMax, 17);
  Coordinates steps{};
  steps.fill(3);
  const CodeTree tree(codes, steps);
  CodeSearch search(tree);
  const auto found = search.nearest({}, 4);
  ASSERT_EQ(found.size(), 4U);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(found[i].index, i);
    EXPECT_EQ(found[i].distance, 16 * 51 * 51);
  }
}

}  // namespace
}  // namespace im2fit::index
