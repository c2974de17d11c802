// SPDX-License-Identifier: Apache-2.0
#include "core/fixed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/rng.h"

namespace im2fit {
namespace {

using Q3_4 = Fixed<std::int8_t, 4>;
using Q0_7 = Fixed<std::int8_t, 7>;
using Q0_15 = Fixed<std::int16_t, 15>;
using Q21_10 = Fixed<std::int32_t, 10>;
using Q1_30 = Fixed<std::int32_t, 30>;

static_assert(std::is_same_v<decltype(Q0_7() * Q0_7()), Q0_7>);
static_assert(std::is_same_v<decltype(Q3_4() * Q0_7()), Q3_4>);
static_assert(std::is_same_v<decltype(Fixed<std::int32_t, 29>() * Fixed<std::int32_t, 12>()), Q21_10>);
static_assert(std::is_same_v<decltype(wide_product(Q1_30(), Q21_10())), Fixed<std::int64_t, 40>>);

// Arm's definition of vqrdmulh, from its words: double the product, add the rounding constant, take the high half,
// saturate. Here everything before the shift is halved, so that 64 bits hold it on 32-bit machines too.
template <class Raw>
Raw vqrdmulh(Raw a, Raw b) {
  constexpr int kBits = 8 * sizeof(Raw);
  const std::int64_t value = (std::int64_t{a} * b + (std::int64_t{1} << (kBits - 2))) >> (kBits - 1);
  constexpr std::int64_t kMax = std::numeric_limits<Raw>::max();
  return static_cast<Raw>(value > kMax ? kMax : value);
}

// What overflows traps in a checked build (fixed_checked_test), so only a plain one is tested.
bool may_try(bool fits) {
  return fits || !kFixedIsChecked;
}
bool fits8(int value) {
  return value >= -128 && value <= 127;
}

TEST(Fixed, EightBitsExhaustively) {
  for (int i = -128; i <= 127; ++i) {
    const auto a = static_cast<std::int8_t>(i);
    for (int j = -128; j <= 127; ++j) {
      const auto b = static_cast<std::int8_t>(j);
      if (may_try(i > -128 || j > -128)) {
        ASSERT_EQ((Q0_7::from_raw(a) * Q0_7::from_raw(b)).raw(), vqrdmulh(a, b)) << i << ' ' << j;
      }
      if (may_try(fits8(i + j))) {
        ASSERT_EQ((Q3_4::from_raw(a) + Q3_4::from_raw(b)).raw(), static_cast<std::int8_t>(i + j));
      }
      if (may_try(fits8(i - j))) {
        ASSERT_EQ((Q3_4::from_raw(a) - Q3_4::from_raw(b)).raw(), static_cast<std::int8_t>(i - j));
      }
      ASSERT_EQ(saturating_add(Q3_4::from_raw(a), Q3_4::from_raw(b)).raw(), std::max(-128, std::min(127, i + j)));
      ASSERT_EQ(wide_product(Q3_4::from_raw(a), Q0_7::from_raw(b)).real(), i / 16.0 * (j / 128.0));
      ASSERT_EQ(Q3_4::from_raw(a) < Q3_4::from_raw(b), i < j);
    }
    ASSERT_EQ(Q3_4::from_raw(a).real(), i / 16.0);
    ASSERT_EQ(Q3_4::from_real(i / 16.0).raw(), i);
    ASSERT_EQ((rescale<1>(Q3_4::from_raw(a)).raw()), static_cast<int>(std::floor(i / 8.0 + 0.5)));
    if (may_try(fits8(i * 4))) {
      ASSERT_EQ((rescale<6>(Q3_4::from_raw(a)).raw()), std::max(-128, std::min(127, i * 4)));
    }
  }
}

TEST(Fixed, SixteenBitProducts) {
  for (int i = -32768; i <= 32767; i += 89) {
    for (int j = -32768; j <= 32767; j += 97) {
      const auto a = static_cast<std::int16_t>(i), b = static_cast<std::int16_t>(j);
      if (!may_try(a > -32768 || b > -32768)) continue;
      ASSERT_EQ((Q0_15::from_raw(a) * Q0_15::from_raw(b)).raw(), vqrdmulh(a, b));
    }
  }
}

TEST(Fixed, ThirtyTwoBitProductsAndTheSaturationCorner) {
  constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min(), kMax = -(kMin + 1);
  const std::int32_t corners[] = {kMin, kMin + 1, -1, 0, 1, 2, kMax - 1, kMax, 1 << 30, -(1 << 30), 1 << 15};
  for (const std::int32_t a : corners) {
    for (const std::int32_t b : corners) {
      if (may_try(a > kMin || b > kMin)) {
        EXPECT_EQ(rounding_doubling_high_multiply(a, b), vqrdmulh(a, b));
      }
    }
  }
  if (may_try(false)) {
    EXPECT_EQ(rounding_doubling_high_multiply(kMin, kMin), kMax);
  }
  Rng rng(3);
  for (int i = 0; i < 200000; ++i) {
    const auto a = static_cast<std::int32_t>(rng.next() >> 32), b = static_cast<std::int32_t>(rng.next() >> 32);
    ASSERT_EQ(rounding_doubling_high_multiply(a, b), vqrdmulh(a, b));
    const double product = (Q1_30::from_raw(a) * Q21_10::from_raw(b)).real();
    ASSERT_NEAR(product, Q1_30::from_raw(a).real() * Q21_10::from_raw(b).real(), 0.5 / 512);
  }
}

TEST(Fixed, FromReal) {
  EXPECT_EQ(Q3_4::from_real(0.03).raw(), 0);
  EXPECT_EQ(Q3_4::from_real(0.03125).raw(), 1);
  EXPECT_EQ(Q3_4::from_real(-0.03125).raw(), -1);
  EXPECT_EQ(Q3_4::from_real(7.9375).raw(), 127);
  EXPECT_EQ(Q3_4::from_real(-8.03).raw(), -128);
  EXPECT_EQ(Q1_30::from_real(1.0).raw(), 1 << 30);
  if (!may_try(false)) return;
  EXPECT_EQ(Q3_4::from_real(7.97).raw(), 127);
  EXPECT_EQ(Q3_4::from_real(1e30).raw(), 127);
  EXPECT_EQ(Q3_4::from_real(-std::numeric_limits<double>::infinity()).raw(), -128);
  EXPECT_EQ(Q3_4::from_real(std::nan("")).raw(), 0);
}

TEST(Fixed, SquareRoots) {
  for (std::uint64_t n = 0; n < 70000; ++n) {
    const std::uint64_t r = integer_square_root(n);
    ASSERT_TRUE(r * r <= n && (r + 1) * (r + 1) > n) << n;
  }
  Rng rng(4);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t r = rng.next() >> 32;
    ASSERT_EQ(integer_square_root(r * r), r);
    if (r > 1) {
      ASSERT_EQ(integer_square_root(r * r - 1), r - 1);
    }
  }
  EXPECT_EQ(integer_square_root(~std::uint64_t{0}), 0xFFFFFFFFU);
  const auto three_four = wide_product(Q21_10::from_real(3), Q21_10::from_real(3)) +
                          wide_product(Q21_10::from_real(4), Q21_10::from_real(4));
  EXPECT_EQ(square_root(three_four).real(), 5.0);
}

}  // namespace
}  // namespace im2fit
