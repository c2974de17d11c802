// SPDX-License-Identifier: Apache-2.0
// The checked build of fixed point traps every overflow; values that do not overflow are unchanged.
#ifndef IM2FIT_CHECKED_FIXED
#define IM2FIT_CHECKED_FIXED
#endif
#include <gtest/gtest.h>

#include "core/fixed.h"

namespace im2fit {
namespace {

using Q21_10 = Fixed<std::int32_t, 10>;
constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();

TEST(FixedCheckedDeathTest, TrapsOverflow) {
  static_assert(kFixedIsChecked);
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto low = Q21_10::from_raw(kMin), high = Q21_10::from_raw(kMax), one = Q21_10::from_raw(1);
  EXPECT_DEATH(static_cast<void>(high + one), "");
  EXPECT_DEATH(static_cast<void>(low - one), "");
  EXPECT_DEATH(static_cast<void>(-low), "");
  EXPECT_DEATH(static_cast<void>(rounding_doubling_high_multiply(kMin, kMin)), "");
  EXPECT_DEATH(static_cast<void>(rescale<11>(high)), "");
  EXPECT_DEATH(static_cast<void>(Q21_10::from_real(3e6)), "");
  EXPECT_DEATH(static_cast<void>(square_root(Fixed<std::int64_t, 20>::from_raw(-1))), "");
}

TEST(FixedChecked, LetsTheRestPass) {
  const auto low = Q21_10::from_raw(kMin), high = Q21_10::from_raw(kMax);
  EXPECT_EQ((high + low).raw(), -1);
  EXPECT_EQ(saturating_add(high, high).raw(), kMax);
  EXPECT_EQ(rounding_doubling_high_multiply(kMin, kMax), -kMax);
  EXPECT_EQ(rescale<11>(Q21_10::from_raw(kMax / 2)).raw(), kMax - 1);
}

}  // namespace
}  // namespace im2fit
