// SPDX-License-Identifier: Apache-2.0
#include "kernels/trees/trees.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::joints {
namespace {

using checkasm::Buffer;

// A tree whose every split tests "pixel 0 - pixel 1 > threshold" with the same threshold at every node goes all right
// or all left; alternating along the path spells the leaf's number in binary.
TEST(SumLeaves, RefFollowsThePathAndAddsTheLeaf) {
  for (int leaf = 0; leaf < kLeafCount; ++leaf) {
    std::vector<Split> splits(kSplitCount, Split{0, 1, 0});
    std::vector<std::int8_t> leaves(kLeafCount * kLeafSize);
    for (std::size_t i = 0; i < leaves.size(); ++i) leaves[i] = static_cast<std::int8_t>(i % 251 - 125);
    int node = 0;
    for (int bit = kSplitDepth - 1; bit >= 0; --bit) {
      const bool right = (leaf >> bit & 1) != 0;
      // pixel 0 - pixel 1 is 100: right below that threshold, left at it.
      splits[static_cast<std::size_t>(node)].threshold = right ? 99 : 100;
      node = 2 * node + (right ? 2 : 1);
    }
    // Of the second of two runs; the first has a difference of 0 and goes left throughout.
    std::int16_t pixels[2 * kRunLanes] = {};
    pixels[1] = 50;
    pixels[kRunLanes + 1] = -50;
    std::int32_t sum[2 * kLeafSize];
    for (std::int32_t& value : sum) value = 1000;
    sum_leaves_ref(splits.data(), leaves.data(), 1, pixels, 2, sum);
    for (int i = 0; i < kLeafSize; ++i) {
      ASSERT_EQ(sum[i], 1000 + i % 251 - 125) << "leaf " << leaf;
      ASSERT_EQ(sum[kLeafSize + i], 1000 + (leaf * kLeafSize + i) % 251 - 125) << "leaf " << leaf;
    }
  }
}

TEST(SumLeaves, EveryTierGivesTheSameSums) {
  checkasm::Trial trial;
  for (int tree_count : checkasm::odd_sizes(70)) {
    const int run_count = 1 + trial.rng().index(kRunLanes);
    IM2FIT_CHECK_PARAMETERS(trial, tree_count << " trees, " << run_count << " runs");
    const auto trees = static_cast<std::size_t>(tree_count);
    constexpr std::size_t kPixels = 30;
    Buffer<Split> splits(trees * kSplitCount, trial.next_end());
    Buffer<std::int8_t> leaves(trees * kLeafCount * kLeafSize, trial.next_end());
    Buffer<std::int16_t> pixels(kPixels * kRunLanes, trial.next_end());
    trial.fill(leaves.span());
    trial.fill(pixels.span(), std::int16_t{-16383}, std::int16_t{16383});
    for (Split& s : splits.span())
      s = {trial.biased<std::uint16_t>(0, kPixels - 1), trial.biased<std::uint16_t>(0, kPixels - 1),
           trial.biased<std::int16_t>(INT16_MIN, INT16_MAX)};
    const std::size_t sums = static_cast<std::size_t>(run_count) * kLeafSize;
    Buffer<std::int32_t> start(sums), want(sums, trial.next_end()), got(sums, trial.next_end());
    trial.fill(start.span(), -1000000, 1000000);
    const auto restart = [&](auto& sum) { std::copy_n(start.data(), sums, sum.data()); };
    restart(want);
    sum_leaves_ref(splits.data(), leaves.data(), tree_count, pixels.data(), run_count, want.data());
    restart(got);
    sum_leaves_portable(splits.data(), leaves.data(), tree_count, pixels.data(), run_count, got.data());
    checkasm::expect_same_bits(want, got);
    checkasm::each_simd(kSumLeavesKernels, [&](const auto& variant) {
      restart(got);
      variant.function(splits.data(), leaves.data(), tree_count, pixels.data(), run_count, got.data());
      checkasm::expect_same_bits(want, got);
    });
  }
}

}  // namespace
}  // namespace im2fit::joints
