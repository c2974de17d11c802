// SPDX-License-Identifier: Apache-2.0
#include "index/code_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/rng.h"
#include "train/index/tree_packing.h"

namespace im2fit::index {
namespace {

using Codes = std::vector<std::int8_t>;  // a point's dimensions follow each other

// By the definition of kernels/code_distance, in the order of the tree.
std::vector<Neighbour> by_definition(const Codes& codes, const PackedTree& packed, const Coordinates& q,
                                     std::size_t count) {
  std::vector<Neighbour> all;
  const auto dimensions = static_cast<std::size_t>(packed.dimension_count);
  for (std::size_t i = 0; i < packed.order.size(); ++i) {
    std::int32_t sum = 0;
    for (std::size_t d = 0; d < dimensions; ++d) {
      const int at = std::clamp(q[d], -kCoordinateMax, kCoordinateMax);
      const int gap = std::min(std::abs(codes[packed.order[i] * dimensions + d] * packed.steps[d] - at), kCodeGapMax);
      sum += gap * gap;
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
  for (int d = 0; d < dimensions; ++d) steps[static_cast<std::size_t>(d)] = 1 + rng.index(kStepMax);
  Codes codes(points * static_cast<std::size_t>(dimensions));
  for (auto& c : codes) c = static_cast<std::int8_t>(coarse ? rng.index(3) : rng.index(256) - 128);
  const PackedTree packed = pack_tree(codes, dimensions, steps);
  CodeSearch search(packed.view());
  for (int trial = 0; trial < 20; ++trial) {
    Coordinates q{};
    const int reach = trial % 4 == 3 ? 2 * kCoordinateMax : trial % 4 == 2 ? 500 : 8000;
    for (int d = 0; d < dimensions; ++d) q[static_cast<std::size_t>(d)] = rng.index(2 * reach) - reach;
    if (trial == 0)
      for (std::size_t d = 0; d < static_cast<std::size_t>(dimensions); ++d) q[d] = codes[d] * steps[d];
    for (const std::size_t k : {std::size_t{1}, std::size_t{7}, std::size_t{32}, std::size_t{kNeighbourMax}}) {
      const auto truth = by_definition(codes, packed, q, k);
      for (const bool all : {false, true}) {
        const auto found = all ? search.exhaustive(q, k) : search.nearest(q, k);
        ASSERT_TRUE(std::equal(found.begin(), found.end(), truth.begin(), truth.end()))
            << points << " points, " << dimensions << " dimensions, k " << k << ", coarse " << coarse << ", all "
            << all;
      }
    }
  }
}

TEST(CodeTree, FindsWhatTheDefinitionSays) {
  compare(1, 4, false, 1);
  compare(23, 1, false, 2);
  compare(3000, 5, false, 3);
  compare(3000, 16, false, 4);
  compare(20000, 3, false, 7);  // several groups of leaves
  compare(60000, 8, false, 9);  // so many that the search ends amid them, in whatever order they are stored
}

TEST(CodeTree, TiesGoToTheSmallerIndex) {
  compare(2000, 3, true, 5);
  compare(700, 1, true, 6);
  compare(30000, 2, true, 10);  // a point in each group of leaves that is as near as the farthest found
}

// Sixteen points at each of 4096 places of a grid, searched at each place of its diagonal for more than lie there:
// the rest lie a step away, in groups whose boxes begin exactly that far off, and those stored first are wanted.
TEST(CodeTree, AGroupExactlyAsFarAsTheFarthestFoundIsSearchedToo) {
  constexpr int kSide = 64;
  Codes codes;
  for (int copy = 0; copy < 16; ++copy)
    for (int i = 0; i < kSide * kSide; ++i) {
      codes.push_back(static_cast<std::int8_t>(i % kSide));
      codes.push_back(static_cast<std::int8_t>(i / kSide));
    }
  const Coordinates steps = {10, 10};
  const PackedTree packed = pack_tree(codes, 2, steps);
  ASSERT_GT(packed.view().group_count(), 4U);
  CodeSearch search(packed.view());
  for (int at = 0; at < kSide; ++at) {
    const Coordinates q = {10 * at, 10 * at};
    const auto truth = by_definition(codes, packed, q, 40);
    const auto found = search.nearest(q, 40);
    ASSERT_TRUE(std::equal(found.begin(), found.end(), truth.begin(), truth.end())) << "at " << at;
  }
}

TEST(CodeTree, EveryRowIsStoredOnceInALeafThatHoldsIt) {
  Rng rng(8);
  const Coordinates steps = {100, 7, 31};
  Codes codes(9000 * 3);
  for (auto& c : codes) c = static_cast<std::int8_t>(std::clamp(rng.normal(0, 40), -127.0, 127.0));
  const PackedTree packed = pack_tree(codes, 3, steps);
  const CodeTree tree = packed.view();
  std::vector<int> seen(9000);
  for (const std::uint32_t row : packed.order) ++seen[row];
  EXPECT_EQ(seen, std::vector<int>(9000, 1));
  EXPECT_EQ(tree.leaf_first.back(), 9000U);
  EXPECT_GT(tree.group_count(), 1U);
  for (std::size_t l = 0; l < tree.leaf_count(); ++l) {
    ASSERT_LE(tree.leaf_first[l + 1] - tree.leaf_first[l], kLeafMax);
    for (std::uint32_t i = tree.leaf_first[l]; i < tree.leaf_first[l + 1]; ++i)
      for (std::size_t d = 0; d < 3; ++d) {
        ASSERT_EQ(tree.code(i, d), codes[packed.order[i] * 3 + d]);
        const int at = tree.code(i, d) * steps[d];
        for (const auto& [boxes, box] :
             {std::pair(tree.leaf_boxes, l), std::pair(tree.group_boxes, l / kGroupLeaves)}) {
          const std::int16_t* edge = boxes.data() + (box / 16 * 3 + d) * 32 + box % 16;
          ASSERT_LE(edge[0], at);
          ASSERT_GE(edge[16], at);
        }
      }
  }
}

TEST(CodeTree, AllPointsAlike) {
  const Codes codes(5000 * 16, 17);
  Coordinates steps{};
  steps.fill(3);
  const PackedTree packed = pack_tree(codes, 16, steps);
  CodeSearch search(packed.view());
  const auto found = search.nearest({}, 4);
  ASSERT_EQ(found.size(), 4U);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(found[i].index, i);
    EXPECT_EQ(found[i].distance, 16 * 51 * 51);
  }
}

}  // namespace
}  // namespace im2fit::index
