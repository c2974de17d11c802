// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

namespace im2fit::lab {
namespace {

// Truth: the value a half stands for, sign (1 + significand/1024) 2^(exponent - 15), in double.
double value_of_half(std::uint16_t h) {
  const int exponent = h >> 10 & 31, significand = h & 1023;
  const double size = exponent == 0 ? std::ldexp(significand, -24) : std::ldexp(1024 + significand, exponent - 25);
  return (h & 0x8000) != 0 ? -size : size;
}

TEST(Half, EveryValueAndTheNearestToAnyOther) {
  for (int bits = 0; bits < 0x10000; ++bits) {
    const auto h = static_cast<std::uint16_t>(bits);
    const float f = float_of(h);
    if ((h >> 10 & 31) == 31) {
      EXPECT_EQ(std::isnan(f), (h & 1023) != 0);
      EXPECT_EQ(std::isinf(f), (h & 1023) == 0);
      continue;
    }
    EXPECT_EQ(static_cast<double>(f), value_of_half(h));
    EXPECT_EQ(half_of(f), h);
    if ((h & 0x7FFF) == 0x7BFF) continue;
    // Between this and the next: the nearer, in the middle the even one.
    const auto next = static_cast<std::uint16_t>(h + 1);
    const double middle = (value_of_half(h) + value_of_half(next)) / 2;
    const auto there = static_cast<float>(middle);
    ASSERT_EQ(static_cast<double>(there), middle);
    EXPECT_EQ(half_of(there), (h & 1) == 0 ? h : next);
    EXPECT_EQ(half_of(std::nextafter(there, f)), h);
    EXPECT_EQ(half_of(std::nextafter(there, float_of(next))), next);
  }
  EXPECT_EQ(half_of(65519.996F), 0x7BFF);
  EXPECT_EQ(half_of(65520.0F), 0x7C00);
  EXPECT_EQ(half_of(1e30F), 0x7C00);
  EXPECT_EQ(half_of(1e-30F), 0);
  EXPECT_TRUE(std::isnan(float_of(half_of(std::numeric_limits<float>::quiet_NaN()))));
}

}  // namespace
}  // namespace im2fit::lab
