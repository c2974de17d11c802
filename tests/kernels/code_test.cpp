// SPDX-License-Identifier: Apache-2.0
// Distances to codes and bounds to boxes.
#include "kernels/code_bounds/code_bounds.h"
#include "kernels/code_distance/code_distance.h"
#include "tests/kernels/checkasm.h"

namespace im2fit {
namespace {

using checkasm::Buffer;

struct Place {
  std::array<std::int32_t, kCodeDimensionMax> steps{}, at{};
};

Place any_place(checkasm::Trial& trial, std::int32_t reach) {
  Place p;
  trial.fill(std::span<std::int32_t>(p.steps), 0, kCodeStepMax);
  trial.fill(std::span<std::int32_t>(p.at), -reach, reach);
  return p;
}

// Norms from the block layout, as the header states it.
std::vector<std::int64_t> norms_of(std::span<const std::int8_t> blocks, const CodeQuery& q, int block_count) {
  std::vector<std::int64_t> out(static_cast<std::size_t>(block_count * kCodeBlock));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const std::size_t pair = i / 32 % static_cast<std::size_t>(q.pair_count);
    const std::size_t block = i / 32 / static_cast<std::size_t>(q.pair_count);
    const std::int64_t at = std::int64_t{blocks[i]} * q.step[2 * pair + i % 2];
    out[block * 16 + i % 32 / 2] += at * at;
  }
  return out;
}

TEST(CodeDistance, RefOnATriangle) {
  const std::int32_t steps[] = {10, 1}, at[] = {0, 4};
  const CodeQuery query(steps, at, 2);
  std::vector<std::int8_t> block(2 * kCodeBlock);
  block[2 * 5] = 3;  // the sixth point is at (30, 0): 30, 4 away
  std::int64_t out[kCodeBlock];
  code_distance_ref(block.data(), nullptr, 1, query, out);
  EXPECT_EQ(out[5], 900 + 16);
  EXPECT_EQ(out[0], 16);
}

TEST(CodeDistance, EveryTierIsExact) {
  checkasm::Trial trial;
  for (int dimensions = 1; dimensions <= kCodeDimensionMax; ++dimensions) {
    for (const int block_count : {1, 2, 3, 7}) {
      for (const std::int32_t reach : {1 << 17, 1 << 20}) {
        IM2FIT_CHECK_PARAMETERS(trial, dimensions << " dimensions, " << block_count << " blocks, reach " << reach);
        const Place p = any_place(trial, reach);
        const CodeQuery query(p.steps.data(), p.at.data(), dimensions);
        const auto points = static_cast<std::size_t>(block_count * kCodeBlock);
        Buffer<std::int8_t> blocks(points * 2 * static_cast<std::size_t>(query.pair_count), trial.next_end());
        trial.fill(blocks.span());
        const auto norm_values = norms_of(blocks.span(), query, block_count);
        Buffer<std::int64_t> norm(points, trial.next_end());
        std::copy(norm_values.begin(), norm_values.end(), norm.data());
        Buffer<std::int64_t> want(points, trial.next_end()), got(points, trial.next_end());
        code_distance_ref(blocks.data(), nullptr, block_count, query, want.data());
        code_distance_portable(blocks.data(), norm.data(), block_count, query, got.data());
        checkasm::expect_same_bits(want, got);
        checkasm::each_simd(kCodeDistanceKernels, [&](const auto& variant) {
          got.refill();
          variant.function(blocks.data(), norm.data(), block_count, query, got.data());
          checkasm::expect_same_bits(want, got);
        });
      }
    }
  }
}

TEST(CodeDistance, LargestDistanceFits) {
  Place p;
  p.steps.fill(kCodeStepMax);
  p.at.fill(kCodePlaceMax + 5);  // clamped
  const CodeQuery query(p.steps.data(), p.at.data(), kCodeDimensionMax);
  const std::vector<std::int8_t> block(kCodeBlock * kCodeDimensionMax, -128);
  const auto norm = norms_of(block, query, 1);
  const std::int64_t gap = std::int64_t{kCodePlaceMax} + 128 * 1024;
  for (const auto& variant : kCodeDistanceKernels) {
    if (!tier_available(variant.tier)) continue;
    std::int64_t out[kCodeBlock];
    variant.function(block.data(), norm.data(), 1, query, out);
    for (const std::int64_t d : out) ASSERT_EQ(d, 16 * gap * gap) << variant.name;
  }
}

TEST(CodeBounds, RefOnABox) {
  std::vector<std::int32_t> block(2 * 2 * kBoxBlock);
  const auto set = [&](std::size_t box, std::size_t d, std::int32_t low, std::int32_t high) {
    block[2 * kBoxBlock * d + box] = low;
    block[2 * kBoxBlock * d + kBoxBlock + box] = high;
  };
  set(3, 0, 100, 200);  // 100 right of the place: 6 steps of 16
  set(3, 1, -50, 50);   // around it
  set(4, 0, -1000, -32);
  set(4, 1, 15, 20);  // less than a step
  set(5, 0, 1 << 20, 1 << 20);
  const std::int32_t place[] = {0, 0};
  std::uint32_t out[kBoxBlock];
  code_bounds_ref(block.data(), 1, place, 2, out);
  EXPECT_EQ(out[3], 36U);
  EXPECT_EQ(out[4], 4U);
  EXPECT_EQ(out[5], 11585U * 11585U);
}

TEST(CodeBounds, EveryTierGivesTheSameBoundsAndNoneIsTooFar) {
  checkasm::Trial trial;
  for (int dimensions = 1; dimensions <= kCodeDimensionMax; ++dimensions) {
    for (const int block_count : {1, 2, 5}) {
      const std::int32_t reach = dimensions % 3 == 0 ? 1 << 21 : 1 << 17;
      IM2FIT_CHECK_PARAMETERS(trial, dimensions << " dimensions, " << block_count << " blocks, reach " << reach);
      const auto boxes = static_cast<std::size_t>(block_count * kBoxBlock);
      Buffer<std::int32_t> blocks(boxes * 2 * static_cast<std::size_t>(dimensions), trial.next_end());
      Buffer<std::int32_t> place(static_cast<std::size_t>(dimensions), trial.next_end());
      trial.fill(blocks.span(), -reach, reach);
      trial.fill(place.span(), -reach, reach);
      for (std::size_t i = 0; i < blocks.size(); i += i % 8 == 7 ? 9 : 1)
        if (blocks[i] > blocks[i + 8]) std::swap(blocks[i], blocks[i + 8]);
      Buffer<std::uint32_t> want(boxes, trial.next_end()), got(boxes, trial.next_end());
      code_bounds_ref(blocks.data(), block_count, place.data(), dimensions, want.data());
      code_bounds_portable(blocks.data(), block_count, place.data(), dimensions, got.data());
      checkasm::expect_same_bits(want, got);
      checkasm::each_simd(kCodeBoundsKernels, [&](const auto& variant) {
        got.refill();
        variant.function(blocks.data(), block_count, place.data(), dimensions, got.data());
        checkasm::expect_same_bits(want, got);
      });
      // The nearest corner is a point of the box.
      for (std::size_t box = 0; box < boxes; ++box) {
        double nearest = 0;
        for (std::size_t d = 0; d < place.size(); ++d) {
          const std::int32_t* edge = blocks.data() + (box / 8 * place.size() + d) * 16 + box % 8;
          const double at = std::clamp<double>(place[d], edge[0], edge[8]);
          nearest += (at - place[d]) * (at - place[d]);
        }
        ASSERT_LE(256.0 * want[box], nearest);
      }
    }
  }
}

}  // namespace
}  // namespace im2fit
