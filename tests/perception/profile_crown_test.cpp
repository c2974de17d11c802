// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "perception/profile/crown.h"
#include "tests/kernels/ray_picture.h"

namespace im2fit::profile {
namespace {

constexpr std::int32_t kSlopeOne = 1 << FormSlope::kFractionBits;

HeightScan scan_of(const test::RayPicture& p, std::int32_t up_offset, std::int32_t side_offset,
                   std::int32_t side_max) {
  return {p.depths(),     p.masks(), p.columns0.data(), p.rows0.data(), p.columns1.data(),
          p.rows1.data(), up_offset, side_offset,       side_max};
}

// Between guard pages: an access outside faults.
void run_guarded(const HeightScan& scan, checkasm::Trial& trial) {
  checkasm::Buffer<std::uint64_t> squares(kHeightBins, trial.next_end());
  sum_by_height(scan, squares.data());
}

TEST(Height, StaysInItsBuffers) {
  checkasm::Trial trial;
  for (const int width : checkasm::odd_sizes(80)) {
    IM2FIT_CHECK_PARAMETERS(trial, width);
    // Slopes of a camera, so that most heights fall into the bins.
    const test::RayPicture p(width, 6, kSlopeOne / 4, 16000, 40000, trial);
    run_guarded(scan_of(p, 900 << 10, trial.biased(-300000, 300000), 400 << 10), trial);
    if (HasFailure()) return;
  }
}

// The largest tables, depths and offsets the contract allows.
TEST(Height, StaysInItsBuffersAtTheExtremes) {
  checkasm::Trial trial;
  for (int turn = 0; turn < 40; ++turn) {
    IM2FIT_CHECK_PARAMETERS(trial, turn);
    const test::RayPicture p(37, 3, kSlopeOne / 8 * 23, 1, 65535, trial);
    run_guarded(
        scan_of(p, trial.biased(-kFormOffsetMax, kFormOffsetMax), trial.biased(-kFormOffsetMax, kFormOffsetMax),
                turn % 2 == 0 ? std::numeric_limits<std::int32_t>::max() : trial.biased(0, kFormOffsetMax)),
        trial);
    run_guarded(scan_of(p, trial.biased(-4000000, 4000000), 0, std::numeric_limits<std::int32_t>::max()), trial);
    if (HasFailure()) return;
  }
}

// One pixel whose place is the offset alone: the side's bound is outside, the lowest height inside.
TEST(Height, BoundsAreExact) {
  const std::int32_t none = 0;
  const std::uint16_t depth = 40000;
  const std::uint8_t mask = 255;
  constexpr std::int32_t kSideMax = 300 << 10, kLowest = kHeightMinMm * (1 << CoordinateMm::kFractionBits);
  const auto scan = [&](std::int32_t up_offset, std::int32_t side_offset) {
    return HeightScan{{&depth, 1, 1}, {&mask, 1, 1}, &none, &none, &none, &none, up_offset, side_offset, kSideMax};
  };
  std::vector<std::uint64_t> squares(kHeightBins);
  for (const std::int32_t side : {kSideMax, -kSideMax})
    EXPECT_EQ(sum_by_height(scan(0, side), squares.data()), kHeightNone);
  for (const std::int32_t side : {kSideMax - 1, 1 - kSideMax})
    EXPECT_EQ(sum_by_height(scan(0, side), squares.data()), 0);
  sum_by_height(scan(kLowest, 0), squares.data());
  EXPECT_EQ(squares[0], 40000U * std::uint64_t{40000});
  sum_by_height(scan(kLowest - 1, 0), squares.data());
  EXPECT_EQ(std::accumulate(squares.begin(), squares.end(), std::uint64_t{0}), 0U);
}

TEST(Height, NothingSeen) {
  checkasm::Trial trial;
  test::RayPicture p(50, 2, kSlopeOne, 1, 65535, trial);
  for (auto& m : p.mask.span()) m = 0;
  std::vector<std::uint64_t> squares(kHeightBins, 1);
  EXPECT_EQ(sum_by_height(scan_of(p, 0, 0, 1 << 20), squares.data()), kHeightNone);
  EXPECT_EQ(std::accumulate(squares.begin(), squares.end(), std::uint64_t{0}), 0U);
}

// In double from the same tables; a point within 2^-10 mm of an edge of a bin or of the side may fall to either side.
std::int32_t sum_in_double(const HeightScan& s, std::vector<std::uint64_t>& squares) {
  constexpr double kSlope = 1.0 / (1 << FormSlope::kFractionBits), kUnit = 1.0 / (1 << CoordinateMm::kFractionBits);
  double lowest = HUGE_VAL;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    for (int u = 0; u < s.depth_q4.width; ++u) {
      const std::uint16_t raw = s.depth_q4.at(u, v);
      if (s.mask.at(u, v) == 0 || raw == 0) continue;
      const double z = raw / 16.0;
      const auto along = [&](const std::int32_t* columns, const std::int32_t* rows, std::int32_t offset) {
        return z * kSlope * (double{1} * columns[u] + rows[v]) + kUnit * offset;
      };
      if (!(std::fabs(along(s.side_columns, s.side_rows, s.side_offset)) < kUnit * s.side_max)) continue;
      const double height = along(s.up_columns, s.up_rows, s.up_offset);
      lowest = std::min(lowest, height);
      const double bin = std::floor((height - kHeightMinMm) / kHeightBinMm);
      if (bin >= 0 && bin < kHeightBins)
        squares[static_cast<std::size_t>(bin)] += static_cast<std::uint64_t>(raw) * raw;
    }
  }
  return lowest < HUGE_VAL ? static_cast<std::int32_t>(std::lround(lowest / kUnit)) : kHeightNone;
}

// Sums may move between two bins where rounding moves a point over their edge; the running sum differs by the points
// that near, here no more than a few points of some thousands.
TEST(Height, AgreesWithDouble) {
  checkasm::Trial trial;
  const test::RayPicture p(120, 60, kSlopeOne / 4, 16000, 40000, trial);
  // Slopes cancel now and then: a height without a part of them lies amid a bin.
  const HeightScan scan = scan_of(p, 902 << 10, 0, 300 << 10);
  std::vector<std::uint64_t> ref(kHeightBins), got(kHeightBins);
  EXPECT_NEAR(sum_by_height(scan, got.data()), sum_in_double(scan, ref), 1);
  double difference = 0, total = 0;
  for (std::size_t i = 0; i < ref.size(); ++i) {
    difference += static_cast<double>(got[i]) - static_cast<double>(ref[i]);
    total += static_cast<double>(ref[i]);
    EXPECT_LT(std::fabs(difference), 3 * 40000.0 * 40000.0) << i;
  }
  EXPECT_GT(total, 300 * 16000.0 * 16000.0);
}

// A wall at depth z, square to a level camera: a row of pixels is one height, (v - cy) z / f, and each pixel's area
// z^2 / f^2. Between two heights lies the wall's area to half a row.
TEST(Height, AWallsAreaIsWidthTimesHeight) {
  constexpr int kWidth = 123, kHeight = 240;
  constexpr double kFocal = 200, kDepth = 2000, kCameraMm = 1000;
  const Intrinsics k = {kWidth, kHeight, kFocal, kFocal, 61, 119.5};
  RayTable rays(kWidth, kHeight);
  rays.set(k);
  RayForm up(kWidth, kHeight), side(kWidth, kHeight);
  up.set(rays, {0, -1, 0});
  side.set(rays, {1, 0, 0});
  const std::vector<std::uint16_t> depth(kWidth * kHeight, static_cast<std::uint16_t>(kDepth * 16));
  const std::vector<std::uint8_t> mask(depth.size(), 255);
  // |side| < 300 mm: 30 pixels of 10 mm to either side, exactly on which rounding decides, so 305.
  const HeightScan scan = {{depth.data(), kWidth, kHeight},
                           {mask.data(), kWidth, kHeight},
                           up.columns(),
                           up.rows(),
                           side.columns(),
                           side.rows(),
                           form_offset(kCameraMm),
                           0,
                           form_offset(305)};
  std::vector<std::uint64_t> squares(kHeightBins);
  const std::int32_t lowest = sum_by_height(scan, squares.data());
  // The lowest row, in 1/1024 mm, to the product's rounding.
  EXPECT_NEAR(lowest, (kCameraMm - 119.5 * kDepth / kFocal) * 1024, 1);
  // From 400 to 1600 mm: bins 125 to 424.
  double area = 0;
  for (std::size_t bin = 125; bin < 425; ++bin) area += static_cast<double>(squares[bin]) / 256 / (kFocal * kFocal);
  EXPECT_NEAR(area, 610 * 1200, 610 * 10);
}

}  // namespace
}  // namespace im2fit::profile
