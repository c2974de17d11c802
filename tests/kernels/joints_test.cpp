// SPDX-License-Identifier: Apache-2.0
#include "kernels/anchors/anchors.h"
#include "kernels/trees/trees.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::joints {
namespace {

using checkasm::Buffer;

// A camera of f = 100 px before a picture of 8 x 4 pixels at 1 m, whose pixel (u, v) lies (10 u, 10 v) mm from the
// optical axis.
TEST(AnchorDepths, RefReadsThePixelUnderThePlace) {
  std::uint16_t depth[8 * 4];
  for (int i = 0; i < 8 * 4; ++i) depth[i] = static_cast<std::uint16_t>(1000 + i);
  depth[2] = 0;
  depth[9] = 4000;
  depth[10] = 100;
  const AnchorBox box = {depth, 8, 4, 0, 0, 100, 100, 0, 0, 1000};
  AnchorJoints joints;
  joints.x[1] = 80;  // joint 0 at the pixel (0, 0), 1 at (8, 0), beside the picture, twice as near
  joints.inverse_z[0] = 0.001F;
  joints.inverse_z[1] = 0.002F;
  const Anchor anchors[] = {{0, 0, 0, 0, 0},     // (0, 0)
                            {30, 20, 0, 0, 0},   // (3, 2)
                            {0, 0, 0, 1, 64},    // a quarter of the way, 20 mm at 1/z = 0.00125: pixel 2.5, so 3
                            {4, -4, 0, 0, 0},    // still (0, 0)
                            {0, 0, 0, 1, 256},   // (16, 0)
                            {-6, 0, 0, 0, 0},    // (-1, 0)
                            {20, 0, 0, 0, 0},    // no person
                            {10, 10, 0, 0, 0},   // far behind
                            {20, 10, 0, 0, 0}};  // far before
  constexpr std::int16_t kExpected[] = {0, 19, 3, 0, 600, 600, 600, 600, -600};
  std::int16_t out[2 * std::size(anchors)] = {};
  anchor_depths_ref(anchors, static_cast<int>(std::size(anchors)), joints, box, out, 2);
  for (std::size_t i = 0; i < std::size(anchors); ++i) {
    EXPECT_EQ(out[2 * i], kExpected[i]) << i;
    EXPECT_EQ(out[2 * i + 1], 0) << i;
  }
}

TEST(AnchorDepths, EveryTierReadsTheSame) {
  checkasm::Trial trial;
  for (int count : checkasm::odd_sizes(70)) {
    const int width = 1 + trial.rng().index(40), height = 1 + trial.rng().index(40);
    const auto step = static_cast<std::ptrdiff_t>(1 + trial.rng().index(8));
    IM2FIT_CHECK_PARAMETERS(trial, count << " anchors, " << width << "x" << height << ", step " << step);
    const auto some = [&](double low, double high) { return static_cast<float>(trial.rng().uniform(low, high)); };
    Buffer<std::uint16_t> depth(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), trial.next_end());
    for (std::uint16_t& z : depth.span())
      z = trial.rng().index(3) == 0 ? std::uint16_t{0} : trial.biased<std::uint16_t>(0, 10000);
    Buffer<Anchor> anchors(static_cast<std::size_t>(count), trial.next_end());
    for (Anchor& a : anchors.span())
      a = {trial.biased<std::int16_t>(-400, 400), trial.biased<std::int16_t>(-400, 400),
           static_cast<std::uint8_t>(trial.rng().index(kAnchorLanes)),
           static_cast<std::uint8_t>(trial.rng().index(kAnchorLanes)), trial.biased<std::int16_t>(0, 256)};
    AnchorJoints joints;
    for (int j = 0; j < kAnchorLanes; ++j) {
      joints.x[j] = some(-300, 300);
      joints.y[j] = some(-300, 300);
      joints.inverse_z[j] = 1 / some(200, 4000);
    }
    const AnchorBox box = {
        depth.data(),  width,         height,        trial.rng().index(20), trial.rng().index(20),
        some(50, 400), some(50, 400), some(-20, 60), some(-20, 60),         trial.rng().index(4000)};
    const std::size_t places = static_cast<std::size_t>(count) * static_cast<std::size_t>(step);
    Buffer<std::int16_t> want(places, trial.next_end()), got(places, trial.next_end());
    const auto run = [&](auto* function, Buffer<std::int16_t>& out) {
      for (std::int16_t& value : out.span()) value = 7;
      function(anchors.data(), count, joints, box, out.data(), step);
    };
    run(anchor_depths_ref, want);
    run(anchor_depths_portable, got);
    checkasm::expect_same_bits(want, got);
    checkasm::each_simd(kAnchorDepthsKernels, [&](const auto& variant) {
      run(variant.function, got);
      checkasm::expect_same_bits(want, got);
    });
  }
}

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
