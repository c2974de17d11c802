// SPDX-License-Identifier: Apache-2.0
#include "kernels/height/height.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/kernels/ray_picture.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

constexpr std::int32_t kSlopeOne = 1 << FormSlope::kFractionBits;

HeightScan scan_of(const test::RayPicture& p, std::int32_t up_offset, std::int32_t side_offset,
                   std::int32_t side_max) {
  return {p.depths(),     p.masks(), p.columns0.data(), p.rows0.data(), p.columns1.data(),
          p.rows1.data(), up_offset, side_offset,       side_max};
}

// Between guard pages: what is read or written outside faults.
void run_guarded(const HeightScan& scan, checkasm::Trial& trial) {
  checkasm::Buffer<std::uint64_t> squares(kHeightBins, trial.next_end());
  height_portable(scan, squares.data());
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
  for (const auto& variant : kHeightWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::vector<std::uint64_t> squares(kHeightBins);
    for (const std::int32_t side : {kSideMax, -kSideMax})
      EXPECT_EQ(variant.function(scan(0, side), squares.data()), kHeightNone) << variant.name;
    for (const std::int32_t side : {kSideMax - 1, 1 - kSideMax})
      EXPECT_EQ(variant.function(scan(0, side), squares.data()), 0) << variant.name;
    variant.function(scan(kLowest, 0), squares.data());
    EXPECT_EQ(squares[0], 40000U * std::uint64_t{40000}) << variant.name;
    variant.function(scan(kLowest - 1, 0), squares.data());
    EXPECT_EQ(std::accumulate(squares.begin(), squares.end(), std::uint64_t{0}), 0U) << variant.name;
  }
}

TEST(Height, NothingSeen) {
  checkasm::Trial trial;
  test::RayPicture p(50, 2, kSlopeOne, 1, 65535, trial);
  for (auto& m : p.mask.span()) m = 0;
  for (const auto& variant : kHeightWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::vector<std::uint64_t> squares(kHeightBins, 1);
    EXPECT_EQ(variant.function(scan_of(p, 0, 0, 1 << 20), squares.data()), kHeightNone);
    EXPECT_EQ(std::accumulate(squares.begin(), squares.end(), std::uint64_t{0}), 0U);
  }
}

// Sums may move between two bins where rounding moves a point over their edge; the running sum differs by what lies
// that near, here no more than a few points of some thousands.
TEST(Height, PortableAgreesWithRef) {
  checkasm::Trial trial;
  const test::RayPicture p(120, 60, kSlopeOne / 4, 16000, 40000, trial);
  // Slopes cancel now and then: a height without a part of them lies amid a bin.
  const HeightScan scan = scan_of(p, 902 << 10, 0, 300 << 10);
  std::vector<std::uint64_t> ref(kHeightBins), got(kHeightBins);
  EXPECT_NEAR(height_portable(scan, got.data()), height_ref(scan, ref.data()), 1);
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
  for (const auto& variant : kHeightWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::vector<std::uint64_t> squares(kHeightBins);
    const std::int32_t lowest = variant.function(scan, squares.data());
    // The lowest row, in 1/1024 mm, to the product's rounding.
    EXPECT_NEAR(lowest, (kCameraMm - 119.5 * kDepth / kFocal) * 1024, 1) << variant.name;
    // From 400 to 1600 mm: bins 125 to 424.
    double area = 0;
    for (std::size_t bin = 125; bin < 425; ++bin) area += static_cast<double>(squares[bin]) / 256 / (kFocal * kFocal);
    EXPECT_NEAR(area, 610 * 1200, 610 * 10) << variant.name;
  }
}

}  // namespace
}  // namespace im2fit
