// SPDX-License-Identifier: Apache-2.0
// The kernels behind DepthFusion; fuse_test.cpp tests their use.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kernels/average/average.h"
#include "kernels/blocks/blocks.h"
#include "kernels/mean/mean.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

const auto kName = [](const auto& p) { return std::string(p.param.name); };
class Average : public testing::TestWithParam<AverageKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Average, testing::ValuesIn(kAverageWithRef), kName);
class Mean : public testing::TestWithParam<MeanKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Mean, testing::ValuesIn(kMeanWithRef), kName);

TEST_P(Average, AddsWhatLiesWithinFiftyMillimetresOfTheMean) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  struct Sample {
    std::uint16_t depth;
    std::uint8_t mask;
    std::uint32_t sum;
    std::uint16_t seen;
    bool added;
  };
  // The mean of 2000 and 2001 is 2000.5: whole depths up to 2050 and from 1951 are within 50 of it.
  const std::vector<Sample> samples = {{2050, 255, 4001, 2, true},
                                       {2051, 255, 4001, 2, false},
                                       {1951, 255, 4001, 2, true},
                                       {1950, 255, 4001, 2, false},
                                       {2000, 0, 4001, 2, false},
                                       {0, 255, 0, 0, false},
                                       {1, 255, 0, 0, true},
                                       {4095, 255, 0, 0, true},
                                       {4096, 255, 0, 0, false},
                                       {65535, 255, 0, 0, false},
                                       {4095, 255, 4095U * 4094, 4094, true}};
  for (const Sample& sample : samples) {
    const std::vector<std::uint16_t> depth(9, sample.depth);
    const std::vector<std::uint8_t> mask(9, sample.mask);
    std::vector<std::uint32_t> sum(9, sample.sum);
    std::vector<std::uint16_t> seen(9, sample.seen);
    GetParam().function(depth.data(), mask.data(), 9, sum.data(), seen.data());
    for (std::size_t i = 0; i < 9; ++i) {
      ASSERT_EQ(sum[i], sample.sum + (sample.added ? sample.depth : 0U)) << sample.depth;
      ASSERT_EQ(seen[i], sample.seen + (sample.added ? 1 : 0)) << sample.depth;
    }
  }
}

TEST_P(Mean, RoundsToTheSixteenth) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  // 3 x 1000.33 = 3001: 16005.33 sixteenths; 2 x 1000.5 / 16 is half a sixteenth and goes up.
  const std::vector<std::uint32_t> sum = {3001, 3002, 4095, 4095U * 4095, 1, 65, 0, 4001};
  const std::vector<std::uint16_t> seen = {3, 3, 1, 4095, 32, 32, 0, 1};
  std::vector<std::uint16_t> depth(8, 7);
  std::vector<std::uint8_t> mask(8, 7);
  GetParam().function(sum.data(), seen.data(), 8, 1, depth.data(), mask.data());
  EXPECT_EQ(depth, (std::vector<std::uint16_t>{16005, 16011, 65520, 65520, 1, 33, 0, 64016}));
  EXPECT_EQ(mask, (std::vector<std::uint8_t>{255, 255, 255, 255, 255, 255, 0, 255}));
  GetParam().function(sum.data(), seen.data(), 8, 32, depth.data(), mask.data());
  EXPECT_EQ(depth, (std::vector<std::uint16_t>{0, 0, 0, 65520, 1, 33, 0, 0}));
  EXPECT_EQ(mask, (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 0, 0}));
}

class Blocks : public testing::TestWithParam<BlocksKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Blocks, testing::ValuesIn(kBlocksWithRef), kName);

TEST_P(Blocks, SumTheFrontSurface) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  // Blocks of 2 x 2: all one surface; two behind by 60 mm and by more; one lost, one not the person's; nothing.
  const std::vector<std::uint16_t> depth = {16000, 16016, 16000, 16960, 16000, 0,     99,
                                            16032, 16000, 16961, 16000, 900,   16004, 99};
  const std::vector<std::uint8_t> mask = {255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 255, 0, 255, 0};
  std::vector<std::uint32_t> sum(3, 7);
  std::vector<std::uint16_t> count(3, 7);
  GetParam().function({depth.data(), 6, 2, 7}, {mask.data(), 6, 2, 7}, {2, 3, 1}, sum.data(), count.data());
  EXPECT_EQ(sum, (std::vector<std::uint32_t>{64048, 48960, 32004}));
  EXPECT_EQ(count, (std::vector<std::uint16_t>{4, 3, 2}));
}

TEST(BlocksCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (int step = 1; step <= kBlockSideMax; ++step) {
    for (int repeat = 0; repeat < 8; ++repeat) {
      const BlockGrid grid = {step, 1 + trial.rng().index(70 / step + 3), 1 + trial.rng().index(3)};
      const int width = grid.columns * step + trial.rng().index(step), height = grid.rows * step;
      const int d_stride = width + trial.rng().index(3), m_stride = width + trial.rng().index(3);
      IM2FIT_CHECK_PARAMETERS(trial, step << ", size " << width << 'x' << height);
      checkasm::Buffer<std::uint16_t> depth(static_cast<std::size_t>((height - 1) * d_stride + width),
                                            trial.next_end());
      checkasm::Buffer<std::uint8_t> mask(static_cast<std::size_t>((height - 1) * m_stride + width),
                                          trial.next_end());
      const int kind = trial.rng().index(3);
      if (kind == 0)
        trial.fill(depth.span());
      else
        trial.fill(depth.span(), std::uint16_t{30000}, static_cast<std::uint16_t>(kind == 1 ? 31200 : 30100));
      const int begin = trial.rng().index(width), end = begin + trial.rng().index(width);  // columns with a person
      for (std::size_t i = 0; i < mask.size(); ++i) {
        const int u = static_cast<int>(i) % m_stride;
        mask[i] = u >= begin && u <= end && trial.rng().index(8) != 0 ? 255 : 0;
        if (trial.rng().index(10) == 0 && i < depth.size()) depth[i] = 0;
      }
      const auto size = static_cast<std::size_t>(grid.columns * grid.rows);
      checkasm::Buffer<std::uint32_t> want_sum(size), got_sum(size, trial.next_end());
      checkasm::Buffer<std::uint16_t> want(size), got(size, trial.next_end());
      const DepthView d(depth.data(), width, height, d_stride);
      const MaskView m(mask.data(), width, height, m_stride);
      blocks_ref(d, m, grid, want_sum.data(), want.data());
      blocks_portable(d, m, grid, got_sum.data(), got.data());
      checkasm::expect_same_bits(want_sum, got_sum);
      checkasm::expect_same_bits(want, got);
      checkasm::each_simd(kBlocksKernels, [&](const auto& variant) {
        got_sum.refill();
        variant.function(d, m, grid, got_sum.data(), got.data());
        checkasm::expect_same_bits(want_sum, got_sum);
        checkasm::expect_same_bits(want, got);
      });
    }
  }
}

TEST(AverageCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (const int count : checkasm::odd_sizes(70)) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    const auto size = static_cast<std::size_t>(count);
    checkasm::Buffer<std::uint16_t> depth(size, trial.next_end()), seen(size, trial.next_end());
    checkasm::Buffer<std::uint8_t> mask(size, trial.next_end());
    checkasm::Buffer<std::uint32_t> sum(size, trial.next_end());
    for (std::size_t i = 0; i < size; ++i) {
      seen[i] = trial.biased<std::uint16_t>(0, 4094);
      const auto middle = trial.biased<std::uint32_t>(1, 4095);
      sum[i] = seen[i] * middle;
      const auto z = static_cast<int>(middle) + trial.biased<int>(-60, 60);
      depth[i] = trial.rng().index(8) == 0 ? trial.biased<std::uint16_t>(0, 65535)
                                           : static_cast<std::uint16_t>(z < 0 ? 0 : z);
      mask[i] = trial.rng().index(4) == 0 ? 0 : 255;
    }
    const auto run = [&](const auto& function, checkasm::Buffer<std::uint32_t>& s,
                         checkasm::Buffer<std::uint16_t>& n) {
      std::copy(sum.data(), sum.data() + size, s.data());
      std::copy(seen.data(), seen.data() + size, n.data());
      function(depth.data(), mask.data(), count, s.data(), n.data());
    };
    checkasm::Buffer<std::uint32_t> want_sum(size), got_sum(size, trial.next_end());
    checkasm::Buffer<std::uint16_t> want_seen(size), got_seen(size, trial.next_end());
    run(average_ref, want_sum, want_seen);
    run(average_portable, got_sum, got_seen);
    checkasm::expect_same_bits(want_sum, got_sum);
    checkasm::expect_same_bits(want_seen, got_seen);
    checkasm::each_simd(kAverageKernels, [&](const auto& variant) {
      run(variant.function, got_sum, got_seen);
      checkasm::expect_same_bits(want_sum, got_sum);
      checkasm::expect_same_bits(want_seen, got_seen);
    });
  }
}

TEST(MeanCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  std::vector<int> counts = checkasm::odd_sizes(70);
  counts.insert(counts.end(), {20000, 20003});  // many quotients
  for (const int count : counts) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    const auto size = static_cast<std::size_t>(count);
    checkasm::Buffer<std::uint32_t> sum(size, trial.next_end());
    checkasm::Buffer<std::uint16_t> seen(size, trial.next_end());
    const int seen_max = trial.rng().index(2) == 0 ? 4095 : 20;
    for (std::size_t i = 0; i < size; ++i) {
      seen[i] = trial.biased<std::uint16_t>(0, static_cast<std::uint16_t>(seen_max));
      sum[i] = trial.biased<std::uint32_t>(0, 4095U * seen[i]);
    }
    const int needed = 1 + trial.rng().index(4);
    checkasm::Buffer<std::uint16_t> want(size), got(size, trial.next_end());
    checkasm::Buffer<std::uint8_t> want_mask(size), got_mask(size, trial.next_end());
    mean_ref(sum.data(), seen.data(), count, needed, want.data(), want_mask.data());
    mean_portable(sum.data(), seen.data(), count, needed, got.data(), got_mask.data());
    checkasm::expect_same_bits(want, got);
    checkasm::expect_same_bits(want_mask, got_mask);
    checkasm::each_simd(kMeanKernels, [&](const auto& variant) {
      got.refill();
      variant.function(sum.data(), seen.data(), count, needed, got.data(), got_mask.data());
      checkasm::expect_same_bits(want, got);
      checkasm::expect_same_bits(want_mask, got_mask);
    });
  }
}

}  // namespace
}  // namespace im2fit
