// SPDX-License-Identifier: Apache-2.0
// The lens' own formula is tested where it is read, in tests/hal.
#include "kernels/undistort/undistort.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

class Undistort : public testing::TestWithParam<UndistortKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Undistort, testing::ValuesIn(kUndistortWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(Undistort, GivesWhatLookingUpEachPixelGives) {
  checkasm::Trial trial;
  for (const int pixels : checkasm::odd_sizes(90)) {
    for (int repeat = 0; repeat < 6; ++repeat) {
      IM2FIT_CHECK_PARAMETERS(trial, pixels << ", repeat " << repeat);
      const auto size = static_cast<std::size_t>(pixels);
      std::vector<std::int32_t> table;
      const int longest = 1 + trial.rng().index(30);
      while (table.size() < size) {
        const int from = trial.rng().index(pixels), none = trial.rng().index(5) == 0 ? 1 : 0;
        for (int k = trial.rng().index(longest); k >= 0 && table.size() < size; --k)
          table.push_back(none != 0 || from + k >= pixels ? -1 : from + k);
        if (repeat == 0) table.assign(size, 0);  // one pixel everywhere
      }
      if (repeat == 1)
        for (std::size_t i = 0; i < size; ++i) table[i] = static_cast<std::int32_t>(i);  // no lens
      if (repeat == 2)
        for (std::size_t i = 0; i < size; ++i) table[i] = std::max(0, static_cast<std::int32_t>(i) - 3);
      const std::vector<UndistortRun> runs = undistort_runs(table);
      checkasm::Buffer<std::uint16_t> in(size, trial.next_end()), want(size), got(size, trial.next_end());
      trial.fill(in.span());
      for (std::size_t i = 0; i < size; ++i)
        want[i] = table[i] < 0 ? std::uint16_t{0} : in[static_cast<std::size_t>(table[i])];
      GetParam().function(in.data(), pixels, runs.data(), static_cast<int>(runs.size()), got.data());
      checkasm::expect_same_bits(want, got);
    }
  }
}

TEST(UndistortRuns, AreAsFewAsCanBe) {
  const std::vector<std::int32_t> table = {3, 4, 5, -1, -1, 9, 8, 9, 10, -1};
  const std::vector<UndistortRun> runs = undistort_runs(table);
  ASSERT_EQ(runs.size(), 5U);
  EXPECT_EQ(runs[0].count, 3);
  EXPECT_EQ(runs[1].from, -1);
  EXPECT_EQ(runs[3].to, 6);
  EXPECT_EQ(runs[3].from, 8);
  EXPECT_EQ(runs[3].count, 3);
}

}  // namespace
}  // namespace im2fit
