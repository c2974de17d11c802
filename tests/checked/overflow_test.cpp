// SPDX-License-Identifier: Apache-2.0
// A build with IM2FIT_CHECKED_FIXED stops the program where a number no longer fits its type. Compiled with the
// device rooms' own flags; checked_rooms.cmake looks whether they have them too.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "core/fixed.h"

namespace im2fit {
namespace {

static_assert(kFixedIsChecked);

// Volatile: the compiler must not know what will overflow.
volatile std::int32_t largest = std::numeric_limits<std::int32_t>::max();
volatile std::int32_t thirty_two = 32;
volatile std::int32_t nothing = 0;
volatile float three_billion = 3e9F;

class Overflow : public testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};
using OverflowDeathTest = Overflow;

TEST_F(OverflowDeathTest, OfFixedPointStops) {
  const auto high = Fixed<std::int32_t, 10>::from_raw(largest);
  EXPECT_DEATH(static_cast<void>(high + high), "");
}

TEST_F(OverflowDeathTest, OfPlainIntegersStops) {
  EXPECT_DEATH(largest = largest + 1, "signed integer overflow");
  EXPECT_DEATH(largest = largest * 2, "signed integer overflow");
  EXPECT_DEATH(largest = -2 - largest, "signed integer overflow");
  EXPECT_DEATH(largest = largest << thirty_two, "shift exponent");
  EXPECT_DEATH(largest = largest / nothing, "division by zero");
  EXPECT_DEATH(largest = static_cast<std::int32_t>(three_billion), "outside the range of representable values");
}

TEST_F(Overflow, WhatFitsGoesOn) {
  EXPECT_EQ(-largest - 1, std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(static_cast<std::int64_t>(three_billion), 3'000'000'000);
  const auto high = Fixed<std::int32_t, 10>::from_raw(largest);
  EXPECT_EQ(saturating_add(high, high).raw(), largest);
}

}  // namespace
}  // namespace im2fit
