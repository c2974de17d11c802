// SPDX-License-Identifier: Apache-2.0
#include "kernels/moments/moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using Sums = std::vector<std::int64_t>;

Sums run(MomentsFunction* function, const SectionPoint* points, int count, int first_x, int last_x,
         checkasm::Guard guard = checkasm::Guard::after) {
  checkasm::Buffer<std::int64_t> sums(kMomentCount, guard);
  function(points, count, first_x, last_x, sums.data());
  return {sums.data(), sums.data() + kMomentCount};
}

void compare_tiers(const SectionPoint* points, int count, int first_x, int last_x, checkasm::Trial& trial) {
  const checkasm::Guard guard = trial.next_end();
  const Sums want = run(moments_portable, points, count, first_x, last_x, guard);
  EXPECT_EQ(want, run(moments_ref, points, count, first_x, last_x, guard));
}

TEST(Moments, TiersAgree) {
  checkasm::Trial trial;
  std::vector<int> counts = checkasm::odd_sizes(70);
  for (const int blocks : {255, 256, 257, 511, 512, 513, 1025, 2000}) counts.push_back(blocks);
  counts.push_back(0);
  for (const int count : counts) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    checkasm::Buffer<SectionPoint> points(static_cast<std::size_t>(count), trial.next_end());
    for (SectionPoint& p : points.span())
      p = {trial.biased<std::int16_t>(-4095, 4095), trial.biased<std::int16_t>(-4095, 4095)};
    compare_tiers(points.data(), count, -4095, 4095, trial);
    compare_tiers(points.data(), count, trial.biased(-4096, 4095), trial.biased(-4096, 4095), trial);
    compare_tiers(points.data(), count, -1000000, 1000000, trial);
    compare_tiers(points.data(), count, 100, 4096, trial);
    if (HasFailure()) return;
  }
}

// As many points as there may be, all at one corner: the sum of x^4 is 32767 * 4095^4, just below 2^63.
TEST(Moments, LargestSums) {
  checkasm::Trial trial;
  for (const int sx : {-4095, 4095}) {
    for (const int sy : {-4095, 4095}) {
      const std::vector<SectionPoint> points(kMomentPointsMax,
                                             {static_cast<std::int16_t>(sx), static_cast<std::int16_t>(sy)});
      compare_tiers(points.data(), kMomentPointsMax, -4095, 4095, trial);
      const Sums sums = run(moments, points.data(), kMomentPointsMax, -4095, 4095);
      EXPECT_EQ(sums[moment_index(4, 0)], std::int64_t{32767} * 4095 * 4095 * 4095 * 4095);
      EXPECT_EQ(sums[moment_index(1, 3)], std::int64_t{32767} * sx * sy * 4095 * 4095);
    }
  }
}

// Whole numbers 1 .. n on a line: Faulhaber's formulas.
TEST(Moments, PowerSums) {
  constexpr std::int64_t n = 1000;
  std::vector<SectionPoint> points;
  for (int i = 1; i <= n; ++i) points.push_back({static_cast<std::int16_t>(i), static_cast<std::int16_t>(-i)});
  for (const auto& variant : kMomentsWithRef) {
    if (!tier_available(variant.tier)) continue;
    const Sums s = run(variant.function, points.data(), n, 1, n);
    EXPECT_EQ(s[moment_index(0, 0)], n);
    EXPECT_EQ(s[moment_index(0, 1)], -n * (n + 1) / 2);
    EXPECT_EQ(s[moment_index(1, 1)], -n * (n + 1) * (2 * n + 1) / 6);
    EXPECT_EQ(s[moment_index(2, 1)], -(n * (n + 1) / 2) * (n * (n + 1) / 2));
    EXPECT_EQ(s[moment_index(2, 2)], n * (n + 1) * (2 * n + 1) * (3 * n * n + 3 * n - 1) / 30);
  }
}

}  // namespace
}  // namespace im2fit
