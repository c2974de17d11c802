// SPDX-License-Identifier: Apache-2.0
#include "kernels/unpack11/unpack11.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "kernels/unpack11/shift_table.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

class Unpack11 : public testing::TestWithParam<Unpack11Kernel> {
 protected:
  void SetUp() override {
    if (!tier_available(GetParam().tier)) GTEST_SKIP() << "this machine has no " << GetParam().name;
  }
};
INSTANTIATE_TEST_SUITE_P(Tiers, Unpack11, testing::ValuesIn(kUnpack11WithRef),
                         [](const auto& p) { return std::string(p.param.name); });

// The bits one by one, as text: slow, and nothing like any tier.
std::vector<std::uint8_t> packed_bits(const std::vector<std::uint16_t>& values, bool rest) {
  std::string bits;
  for (const std::uint16_t value : values)
    for (int power = 1024; power > 0; power /= 2) bits += (value / power) % 2 == 1 ? '1' : '0';
  while (bits.size() % 8 != 0) bits += rest ? '1' : '0';
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < bits.size(); i += 8)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(bits.substr(i, 8), nullptr, 2)));
  return bytes;
}

TEST_P(Unpack11, GivesTheNumbersThatWereWrittenBitByBit) {
  checkasm::Trial trial;
  std::vector<int> sizes = checkasm::odd_sizes(90);
  sizes.push_back(640);
  for (const int count : sizes) {
    for (const bool rest : {false, true}) {
      IM2FIT_CHECK_PARAMETERS(trial, count << ", padded with " << rest);
      std::vector<std::uint16_t> values(static_cast<std::size_t>(count));
      trial.fill(std::span<std::uint16_t>(values), std::uint16_t{0}, std::uint16_t{2047});
      const auto bytes = packed_bits(values, rest);
      ASSERT_EQ(bytes.size(), unpack11_bytes(count));
      checkasm::Buffer<std::uint8_t> packed(bytes.size(), trial.next_end());
      std::copy(bytes.begin(), bytes.end(), packed.data());
      checkasm::Buffer<std::uint16_t> got(values.size(), trial.next_end());
      GetParam().function(packed.data(), count, got.data());
      checkasm::expect_same_bits(std::span<const std::uint16_t>(values), std::span<const std::uint16_t>(got.span()));
    }
  }
}

// One value set at a time: no bit of a neighbour leaks in, at any place of the group and across groups.
TEST_P(Unpack11, KeepsNeighboursApart) {
  for (std::size_t at = 0; at < 40; ++at) {
    std::vector<std::uint16_t> values(40, 0);
    values[at] = 2047;
    const auto bytes = packed_bits(values, false);
    std::vector<std::uint16_t> got(40, 9);
    GetParam().function(bytes.data(), 40, got.data());
    EXPECT_EQ(got, values) << "value " << at;
  }
}

TEST_P(Unpack11, OfNothingWritesNothing) {
  std::uint16_t out = 7;
  const std::uint8_t packed = 0xFF;
  GetParam().function(&packed, 0, &out);
  EXPECT_EQ(out, 7);
}

// The formula as it is published, in long double.
long double published_mm(int raw, long double emitter_cm, long double distance_cm, long double pixel_cm, int shift) {
  const long double m =
      ((static_cast<long double>(raw) - 4.0L * static_cast<long double>(shift)) / 4.0L - 0.375L) * pixel_cm;
  return 10.0L * (m * distance_cm / (emitter_cm - m) + distance_cm);
}

TEST(ShiftTable, IsThePublishedFormulaToHalfAMillimetre) {
  struct {
    ZeroPlane plane;
    long double emitter_cm, distance_cm, pixel_cm;
  } const cases[] = {{{}, 7.5L, 120.0L, 0.1042L},
                     {{75'000'000, 1'200'000'000, 1'052'000, 200}, 7.5L, 120.0L, 0.1052L},
                     {{52'500'000, 900'000'000, 980'500, 150}, 5.25L, 90.0L, 0.09805L}};
  for (const auto& c : cases) {
    const ShiftTable table = shift_table(c.plane);
    int seen = 0;
    for (int raw = 0; raw < kShiftCount - 1; ++raw) {
      const long double z_mm = published_mm(raw, c.emitter_cm, c.distance_cm, c.pixel_cm, c.plane.constant_shift);
      const int got = table[static_cast<std::size_t>(raw)];
      if (z_mm < 0 || z_mm >= 10'000.5L) {
        EXPECT_EQ(got, 0) << "raw " << raw;
      } else {
        EXPECT_LE(std::fabs(static_cast<long double>(got) - z_mm), 0.5L + 1e-6L) << "raw " << raw;
        ++seen;
      }
    }
    EXPECT_GT(seen, 700);
    EXPECT_EQ(table[kNoShift], 0);
  }
}

// Anchors computed by hand from e r / (e - m): raw 803.0 / 4 - 200 - 0.375 = 0.375, m = 0.0390750, z = 1206.28 mm.
TEST(ShiftTable, HasTheseValues) {
  const ShiftTable table = shift_table({});
  EXPECT_EQ(table[803], 1206);
  EXPECT_EQ(table[0], 317);
  EXPECT_EQ(table[1000], 3864);
  EXPECT_EQ(table[1084], 0);  // 63.9 m
  for (int raw = 1; raw < kShiftCount; ++raw) {
    const auto i = static_cast<std::size_t>(raw);
    EXPECT_TRUE(table[i] == 0 || table[i] >= table[i - 1]) << "nearer although the shift is larger: " << raw;
  }
}

TEST(ShiftTable, KnowsWhatIsNoCamera) {
  EXPECT_TRUE(is_plausible({}));
  EXPECT_FALSE(is_plausible({0, 1'200'000'000, 1'042'000, 200}));
  EXPECT_FALSE(is_plausible({75'000'000, 1'200'000'000, 0, 200}));
  EXPECT_FALSE(is_plausible({75'000'000, 120'000'000'000, 1'042'000, 200}));
  EXPECT_FALSE(is_plausible({75'000'000, 1'200'000'000, 1'042'000, -1}));
  EXPECT_FALSE(is_plausible({75'000'000, 1'200'000'000, 1'042'000, 65535}));
  EXPECT_NEAR(focal_length_px({}), 575.816F, 0.001F);
  for (const ZeroPlane& extreme :
       {ZeroPlane{200'000'000, 5'000'000'000, 10'000'000, 0}, ZeroPlane{10'000'000, 100'000'000, 100'000, 1000}}) {
    ASSERT_TRUE(is_plausible(extreme));
    for (const std::uint16_t mm : shift_table(extreme)) EXPECT_LE(mm, 10'000);
  }
}

TEST(ShiftsToMm, GoThroughTheTable) {
  checkasm::Trial trial;
  const ShiftTable table = shift_table({});
  for (const int count : {1, 7, 8, 639, 640, 641, 1280, 1927}) {
    std::vector<std::uint16_t> values(static_cast<std::size_t>(count));
    trial.fill(std::span<std::uint16_t>(values), std::uint16_t{0}, std::uint16_t{2047});
    const auto bytes = packed_bits(values, true);
    checkasm::Buffer<std::uint8_t> packed(bytes.size(), trial.next_end());
    std::copy(bytes.begin(), bytes.end(), packed.data());
    checkasm::Buffer<std::uint16_t> out(values.size(), trial.next_end());
    shifts_to_mm(packed.data(), count, table, out.data());
    for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(out[i], table[values[i]]) << count << " at " << i;
  }
}

}  // namespace
}  // namespace im2fit
