// SPDX-License-Identifier: Apache-2.0
// Distances to codes and bounds to boxes.
#include "kernels/code_bounds/code_bounds.h"
#include "kernels/code_distance/code_distance.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using checkasm::Buffer;

TEST(CodeDistance, RefOnATriangle) {
  const std::int32_t steps[] = {10, 1}, at[] = {0, 4};
  const CodeQuery query(steps, at, 2);
  std::vector<std::int8_t> block(2 * kCodeBlock);
  block[2 * 5] = 3;      // the sixth point is at (30, 0): 30, 4 away
  block[2 * 9 + 1] = 1;  // the tenth at (0, 1)
  std::int32_t out[kCodeBlock], least = 0;
  code_distance_ref(block.data(), 1, query, out, &least);
  EXPECT_EQ(out[5], 900 + 16);
  EXPECT_EQ(out[0], 16);
  EXPECT_EQ(least, 9);
}

TEST(CodeDistance, EveryTierIsExact) {
  checkasm::Trial trial;
  for (int dimensions = 1; dimensions <= kCodeDimensionMax; ++dimensions) {
    for (const int block_count : {1, 2, 3, 7}) {
      for (const std::int32_t reach : {1000, 2 * kCodePlaceMax}) {
        IM2FIT_CHECK_PARAMETERS(trial, dimensions << " dimensions, " << block_count << " blocks, reach " << reach);
        std::array<std::int32_t, kCodeDimensionMax> steps{}, at{};
        trial.fill(std::span<std::int32_t>(steps), 0, kCodeStepMax);
        trial.fill(std::span<std::int32_t>(at), -reach, reach);
        const CodeQuery query(steps.data(), at.data(), dimensions);
        const auto points = static_cast<std::size_t>(block_count * kCodeBlock);
        Buffer<std::int8_t> blocks(points * 2 * static_cast<std::size_t>(query.pair_count), trial.next_end());
        trial.fill(blocks.span());
        Buffer<std::int32_t> want(points, trial.next_end()), got(points, trial.next_end());
        const auto count = static_cast<std::size_t>(block_count);
        Buffer<std::int32_t> want_least(count, trial.next_end()), got_least(count, trial.next_end());
        code_distance_ref(blocks.data(), block_count, query, want.data(), want_least.data());
        code_distance_portable(blocks.data(), block_count, query, got.data(), got_least.data());
        checkasm::expect_same_bits(want, got);
        checkasm::expect_same_bits(want_least, got_least);
        checkasm::each_simd(kCodeDistanceKernels, [&](const auto& variant) {
          got.refill();
          got_least.refill();
          variant.function(blocks.data(), block_count, query, got.data(), got_least.data());
          checkasm::expect_same_bits(want, got);
          checkasm::expect_same_bits(want_least, got_least);
        });
      }
    }
  }
}

TEST(CodeDistance, LongGapsAreCutAndTheLargestSumFits) {
  std::array<std::int32_t, kCodeDimensionMax> steps{}, at{};
  steps.fill(kCodeStepMax);
  at.fill(kCodePlaceMax + 5);  // clamped
  const CodeQuery query(steps.data(), at.data(), kCodeDimensionMax);
  const std::vector<std::int8_t> block(kCodeBlock * kCodeDimensionMax, -128);
  for (const auto& variant : kCodeDistanceWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::int32_t out[kCodeBlock], least = 0;
    variant.function(block.data(), 1, query, out, &least);
    for (const std::int32_t d : out) ASSERT_EQ(d, 16 * 11585 * 11585) << variant.name;
  }
}

TEST(CodeBounds, RefOnABox) {
  std::vector<std::int16_t> block(2 * 2 * kBoxBlock);
  const auto set = [&](std::size_t box, std::size_t d, int low, int high) {
    block[2 * kBoxBlock * d + box] = static_cast<std::int16_t>(low);
    block[2 * kBoxBlock * d + kBoxBlock + box] = static_cast<std::int16_t>(high);
  };
  set(3, 0, 100, 200);  // 100 right of the place
  set(3, 1, -50, 50);   // around it
  set(4, 0, -1000, -32);
  set(4, 1, 15, 20);
  set(15, 0, kCodePlaceMax, kCodePlaceMax);
  const std::int16_t place[] = {0, 0};
  std::int32_t out[kBoxBlock];
  code_bounds_ref(block.data(), 1, place, 2, out);
  EXPECT_EQ(out[3], 10000);
  EXPECT_EQ(out[4], 32 * 32 + 15 * 15);
  EXPECT_EQ(out[15], 11585 * 11585);
}

TEST(CodeBounds, EveryTierIsExactAndNoPointOfABoxIsNearer) {
  checkasm::Trial trial;
  for (int dimensions = 1; dimensions <= kCodeDimensionMax; ++dimensions) {
    for (const int block_count : {1, 2, 5}) {
      IM2FIT_CHECK_PARAMETERS(trial, dimensions << " dimensions, " << block_count << " blocks");
      // Boxes round sixteen random points each, as a tree's leaves are.
      std::array<std::int32_t, kCodeDimensionMax> steps{}, at{};
      trial.fill(std::span<std::int32_t>(steps), 0, kCodeStepMax);
      trial.fill(std::span<std::int32_t>(at), -kCodePlaceMax, kCodePlaceMax);
      const CodeQuery query(steps.data(), at.data(), dimensions);
      const auto boxes = static_cast<std::size_t>(block_count * kBoxBlock);
      const auto pairs = static_cast<std::size_t>(query.pair_count);
      std::vector<std::int8_t> points(boxes * kCodeBlock * 2 * pairs);
      trial.fill(std::span<std::int8_t>(points));
      Buffer<std::int16_t> blocks(boxes * 2 * static_cast<std::size_t>(dimensions), trial.next_end());
      for (std::size_t box = 0; box < boxes; ++box) {
        for (std::size_t d = 0; d < static_cast<std::size_t>(dimensions); ++d) {
          int low = 127, high = -128;
          for (std::size_t i = 0; i < kCodeBlock; ++i) {
            const int code = points[((box * pairs + d / 2) * kCodeBlock + i) * 2 + d % 2];
            low = std::min(low, code);
            high = std::max(high, code);
          }
          std::int16_t* edge = blocks.data() +
                               (box / kBoxBlock * static_cast<std::size_t>(dimensions) + d) * 2 * kBoxBlock +
                               box % kBoxBlock;
          edge[0] = static_cast<std::int16_t>(low * steps[d]);
          edge[kBoxBlock] = static_cast<std::int16_t>(high * steps[d]);
        }
      }
      Buffer<std::int32_t> want(boxes, trial.next_end()), got(boxes, trial.next_end());
      code_bounds_ref(blocks.data(), block_count, query.place.data(), dimensions, want.data());
      code_bounds_portable(blocks.data(), block_count, query.place.data(), dimensions, got.data());
      checkasm::expect_same_bits(want, got);
      checkasm::each_simd(kCodeBoundsKernels, [&](const auto& variant) {
        got.refill();
        variant.function(blocks.data(), block_count, query.place.data(), dimensions, got.data());
        checkasm::expect_same_bits(want, got);
      });
      std::vector<std::int32_t> distance(boxes * kCodeBlock);
      std::vector<std::int32_t> nearest(boxes);
      code_distance_ref(points.data(), static_cast<int>(boxes), query, distance.data(), nearest.data());
      for (std::size_t box = 0; box < boxes; ++box) ASSERT_LE(want[box], nearest[box]);
    }
  }
}

}  // namespace
}  // namespace im2fit
