// SPDX-License-Identifier: Apache-2.0
// The harness itself: it finds the faults that it must find.
#include "tests/kernels/checkasm.h"

#include <gtest/gtest-spi.h>

#include <cstdlib>

namespace im2fit {
namespace {

using checkasm::Buffer;
using checkasm::Guard;

using AddOneFunction = void(const std::uint8_t* in, int count, std::uint8_t* out);
void add_one_ref(const std::uint8_t* in, int count, std::uint8_t* out) {
  for (int i = 0; i < count; ++i) out[i] = static_cast<std::uint8_t>(in[i] + 1);
}
void add_one_portable(const std::uint8_t* in, int count, std::uint8_t* out) {
  add_one_ref(in, count, out);
}
// Forgets the values after the last full block of 8.
[[maybe_unused]] void add_one_simd(const std::uint8_t* in, int count, std::uint8_t* out) {
  add_one_ref(in, count - count % 8, out);
}
#if IM2FIT_HAVE_NEON
constexpr Tier kHere = Tier::neon;
#else
constexpr Tier kHere = Tier::avx2;
#endif
constexpr KernelVariant<AddOneFunction> kVariants[] = {
    IM2FIT_KERNEL(add_one, ref) IM2FIT_KERNEL(add_one, portable){"forgetful", add_one_simd, kHere}};

void compare(int count) {
  checkasm::Trial trial;
  Buffer<std::uint8_t> in(static_cast<std::size_t>(count)), want(in.size()), got(in.size());
  trial.fill(in.span());
  add_one_portable(in.data(), count, want.data());
  checkasm::each_simd(kVariants, [&](const auto& variant) {
    variant.function(in.data(), count, got.data());
    checkasm::expect_same_bits(want, got);
  });
}

TEST(CheckAsm, ForgottenTailIsSeen) {
  if (!tier_available(kHere)) GTEST_SKIP() << "no hand-written tier here";
  compare(16);
  EXPECT_NONFATAL_FAILURE(compare(17), "value 16 of 17");
}

TEST(CheckAsm, ValueWrittenBesideTheBufferIsSeen) {
  EXPECT_NONFATAL_FAILURE(
      {
        Buffer<std::uint8_t> b(10, Guard::before);
        b.data()[10] = 0;
      },
      "beside the buffer of 10");
  EXPECT_NONFATAL_FAILURE(
      {
        Buffer<std::uint16_t> b(10);
        b.data()[-1] = 0;
      },
      "beside the buffer of 10");
}

TEST(CheckAsmDeathTest, GuardPagesFault) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        Buffer<std::uint16_t> b(10);
        volatile std::uint16_t* p = b.data();
        (void)p[10];
      },
      "");
  EXPECT_DEATH(
      {
        Buffer<std::uint16_t> b(10, Guard::before);
        volatile std::uint16_t* p = b.data();
        (void)p[-1];
      },
      "");
}

TEST(CheckAsm, BiasedValuesReachBothEnds) {
  checkasm::Trial trial;
  int low = 0, high = 0, middle = 0;
  for (int i = 0; i < 8000; ++i) {
    const auto v = trial.biased<std::int16_t>(-1000, 30000);
    ASSERT_GE(v, -1000);
    ASSERT_LE(v, 30000);
    low += v <= -985 ? 1 : 0;
    high += v >= 29985 ? 1 : 0;
    middle += v > 0 && v < 20000 ? 1 : 0;
  }
  EXPECT_NEAR(low, 1000, 200);
  EXPECT_NEAR(high, 1000, 200);
  EXPECT_GT(middle, 3000);
}

#ifdef IM2FIT_TIER_SWITCH
TEST(Tiers, EnvironmentDisablesNamedOnes) {
  const char* before = std::getenv("IM2FIT_DISABLE_TIERS");
  const std::string restore = before == nullptr ? "" : before;
  unsetenv("IM2FIT_DISABLE_TIERS");
  const bool neon = tier_available(Tier::neon), avx2 = tier_available(Tier::avx2);
  setenv("IM2FIT_DISABLE_TIERS", "avx2", 1);
  EXPECT_FALSE(tier_available(Tier::avx2));
  EXPECT_EQ(tier_available(Tier::neon), neon);
  setenv("IM2FIT_DISABLE_TIERS", "avx,avx22,neon", 1);
  EXPECT_FALSE(tier_available(Tier::neon));
  EXPECT_EQ(tier_available(Tier::avx2), avx2);
  EXPECT_TRUE(tier_available(Tier::portable));
  setenv("IM2FIT_DISABLE_TIERS", restore.c_str(), 1);
}
#endif

}  // namespace
}  // namespace im2fit
