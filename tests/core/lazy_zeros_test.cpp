// SPDX-License-Identifier: Apache-2.0
#include "core/lazy_zeros.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "tests/devices/process_state.h"

namespace im2fit {
namespace {

TEST(LazyZeros, AreZeroAndMove) {
  LazyZeros<std::uint16_t> values(1000);
  ASSERT_EQ(values.size(), 1000U);
  EXPECT_TRUE(std::all_of(values.begin(), values.end(), [](std::uint16_t v) { return v == 0; }));
  values[999] = 7;
  LazyZeros<std::uint16_t> moved(std::move(values));
  EXPECT_EQ(moved[999], 7);
  LazyZeros<std::uint16_t> assigned;
  EXPECT_EQ(assigned.size(), 0U);
  assigned = std::move(moved);
  EXPECT_EQ(assigned[999], 7);
  EXPECT_EQ(assigned.end() - assigned.begin(), 1000);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(LazyZeros, TakeMemoryWhereTheyAreWritten) {
  constexpr std::size_t kMegabyte = 1 << 20;
  const long before_kb = devices::resident_kb();
  LazyZeros<std::uint8_t> values(64 * kMegabyte);
  EXPECT_LT(devices::resident_kb() - before_kb, 8 * 1024);
  std::fill_n(values.begin(), 32 * kMegabyte, std::uint8_t{1});
  EXPECT_GT(devices::resident_kb() - before_kb, 30 * 1024);
  EXPECT_LT(devices::resident_kb() - before_kb, 40 * 1024);
  EXPECT_EQ(values[32 * kMegabyte], 0);
}

// Not only the first time, before the allocator has learned how large blocks are.
TEST(LazyZeros, GiveMemoryBack) {
  constexpr std::size_t kMegabyte = 1 << 20;
  const long before_kb = devices::resident_kb();
  for (int i = 0; i < 20; ++i) {
    LazyZeros<std::uint8_t> values(16 * kMegabyte);
    std::fill_n(values.begin(), kMegabyte, std::uint8_t{1});
    EXPECT_EQ(values[2 * kMegabyte], 0);
    EXPECT_LT(devices::resident_kb() - before_kb, 4 * 1024);
  }
  EXPECT_LT(devices::resident_kb() - before_kb, 2 * 1024);
}
#endif

}  // namespace
}  // namespace im2fit
