// SPDX-License-Identifier: Apache-2.0
#include "kernels/contour/contour.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using checkasm::Buffer;

// Person-like rows: stretches of mask, depths that mostly creep and sometimes jump, holes in either.
struct Picture {
  int width, height, depth_stride, mask_stride;
  Buffer<std::uint16_t> depth;
  Buffer<std::uint8_t> mask;

  // Strides beyond the width: what lies between is not to be counted, and the last row ends with its pixels.
  Picture(int w, int h, int depth_gap, int mask_gap, checkasm::Trial& trial)
      : width(w),
        height(h),
        depth_stride(w + depth_gap),
        mask_stride(w + mask_gap),
        depth(static_cast<std::size_t>(depth_stride * (h - 1) + w), trial.next_end()),
        mask(static_cast<std::size_t>(mask_stride * (h - 1) + w), trial.next_end()) {
    const auto draw = [&](int count) { return trial.rng().index(count); };
    trial.fill(depth.span());
    int level = 30000, left = 0;
    bool inside = false;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      if (left-- == 0) left = draw(90), inside = !inside;
      if (draw(40) == 0) level = trial.biased<int>(1, 65535);
      // Differences about the step itself, in both directions.
      const int next =
          level + (draw(8) == 0 ? (draw(2) == 0 ? 1 : -1) * (kContourStepQ4 - 2 + draw(4)) : draw(33) - 16);
      if (draw(10) != 0) depth[i] = static_cast<std::uint16_t>(std::clamp(next, 0, 65535));
      if (next > 0 && next < 65536) level = next;
    }
    for (std::size_t i = 0; i < mask.size(); ++i) {
      if (left-- <= 0) left = draw(150), inside = !inside;
      // Masks are 0 or 255; any other value counts as set.
      mask[i] =
          inside && draw(30) != 0 ? static_cast<std::uint8_t>(draw(4) == 0 ? 1 + draw(255) : 255) : std::uint8_t{0};
    }
  }
  ImageView<const std::uint16_t> depths() const { return {depth.data(), width, height, depth_stride}; }
  MaskView masks() const { return {mask.data(), width, height, mask_stride}; }
};

struct Result {
  Buffer<ContourRow> rows;
  Buffer<std::uint64_t> seen, steps;
  Result(int width, int height, checkasm::Guard guard)
      : rows(static_cast<std::size_t>(height), guard),
        seen(static_cast<std::size_t>(height) * contour_words(width), guard),
        steps(seen.size(), guard) {}
};

void expect_same(const Result& want, const Result& got) {
  checkasm::expect_same_bits(want.seen, got.seen);
  checkasm::expect_same_bits(want.steps, got.steps);
  for (std::size_t v = 0; v < want.rows.size(); ++v) {
    const ContourRow &a = want.rows.data()[v], &b = got.rows.data()[v];
    EXPECT_EQ(a.first, b.first) << "row " << v;
    EXPECT_EQ(a.last, b.last) << "row " << v;
    EXPECT_EQ(a.count, b.count) << "row " << v;
    EXPECT_EQ(a.depth_sum, b.depth_sum) << "row " << v;
    EXPECT_EQ(a.depth_square_sum, b.depth_square_sum) << "row " << v;
  }
}

void compare_tiers(const Picture& picture, checkasm::Trial& trial) {
  const checkasm::Guard guard = trial.next_end();
  Result ref(picture.width, picture.height, guard), want(picture.width, picture.height, guard);
  contour_ref(picture.depths(), picture.masks(), ref.rows.data(), ref.seen.data(), ref.steps.data());
  contour_portable(picture.depths(), picture.masks(), want.rows.data(), want.seen.data(), want.steps.data());
  expect_same(ref, want);
  checkasm::each_simd(kContourKernels, [&](const auto& variant) {
    Result got(picture.width, picture.height, guard);
    variant.function(picture.depths(), picture.masks(), got.rows.data(), got.seen.data(), got.steps.data());
    expect_same(want, got);
  });
}

TEST(Contour, TiersAgree) {
  checkasm::Trial trial;
  for (const int width : checkasm::odd_sizes(200)) {
    IM2FIT_CHECK_PARAMETERS(trial, width);
    compare_tiers(Picture(width, 5, width % 3, width % 5, trial), trial);
    if (HasFailure()) return;
  }
}

TEST(Contour, WidestRowsAtBothExtremes) {
  checkasm::Trial trial;
  for (const int depth : {65535, 1}) {
    Picture picture(kImageSideMax, 2, 0, 0, trial);
    for (auto& d : picture.depth.span()) d = static_cast<std::uint16_t>(depth);
    for (auto& m : picture.mask.span()) m = 255;
    compare_tiers(picture, trial);
    Result got(picture.width, 2, checkasm::Guard::after);
    contour(picture.depths(), picture.masks(), got.rows.data(), got.seen.data(), got.steps.data());
    EXPECT_EQ(got.rows[1].depth_sum, 2048U * static_cast<unsigned>(depth));
    EXPECT_EQ(got.rows[1].depth_square_sum, 2048U * static_cast<std::uint64_t>(depth) * static_cast<unsigned>(depth));
  }
}

// A run that ends before a word of 64 without the person is not a neighbour of one that begins behind it.
TEST(Contour, AnEmptyWordLiesBetween) {
  constexpr int kWidth = 192;
  std::vector<std::uint16_t> depth(kWidth, 20000);
  std::fill(depth.begin() + 128, depth.end(), std::uint16_t{40000});
  std::vector<std::uint8_t> mask(kWidth, 255);
  std::fill(mask.begin() + 64, mask.begin() + 128, std::uint8_t{0});
  for (const auto& variant : kContourWithRef) {
    if (!tier_available(variant.tier)) continue;
    ContourRow row{};
    std::array<std::uint64_t, 3> seen{}, steps{};
    variant.function({depth.data(), kWidth, 1}, {mask.data(), kWidth, 1}, &row, seen.data(), steps.data());
    EXPECT_EQ(seen[1], 0U) << variant.name;
    for (const std::uint64_t word : steps) EXPECT_EQ(word, 0U) << variant.name;
  }
}

// A disc of radius r about the middle of a pixel: rows' ends and sums have closed forms.
TEST(Contour, DiscInFrontOfAWall) {
  constexpr int kSide = 301, kRadius = 100, kNear = 20000, kFar = kNear + kContourStepQ4;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask(kSide * kSide, 255);
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      depth.push_back(static_cast<std::uint16_t>(std::hypot(u - 150, v - 150) <= kRadius ? kNear : kFar));
  const std::size_t words = contour_words(kSide);
  for (const auto& variant : kContourWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::vector<ContourRow> rows(kSide);
    std::vector<std::uint64_t> seen(kSide * words), steps(seen.size());
    const auto run = [&] {
      variant.function({depth.data(), kSide, kSide}, {mask.data(), kSide, kSide}, rows.data(), seen.data(),
                       steps.data());
    };
    run();
    const auto steps_of = [&](int v) {
      std::vector<int> columns;
      for (int u = 0; u < kSide; ++u)
        if ((steps[static_cast<std::size_t>(v) * words + static_cast<std::size_t>(u) / 64] >> (u % 64) & 1) != 0)
          columns.push_back(u);
      return columns;
    };
    for (int v = 0; v < kSide; ++v) {
      const int dv = std::abs(v - 150);
      const ContourRow& row = rows[static_cast<std::size_t>(v)];
      EXPECT_EQ(row.first, 0);
      EXPECT_EQ(row.last, kSide - 1);
      if (dv > kRadius) {
        EXPECT_EQ(row.depth_sum, static_cast<unsigned>(kSide * kFar));
        EXPECT_TRUE(steps_of(v).empty());
      } else {
        const int half = static_cast<int>(std::sqrt(kRadius * kRadius - dv * dv));
        EXPECT_EQ(row.depth_sum, static_cast<unsigned>(kSide * kFar - (2 * half + 1) * kContourStepQ4));
        EXPECT_EQ(steps_of(v), (std::vector<int>{150 - half, 150 + half + 1}));
      }
    }
    // One unit less is not a step.
    for (auto& d : depth)
      if (d == kFar) --d;
    run();
    for (int v = 0; v < kSide; ++v) EXPECT_TRUE(steps_of(v).empty());
    for (auto& d : depth)
      if (d == kFar - 1) ++d;
    // An empty picture.
    mask.assign(mask.size(), 0);
    run();
    EXPECT_EQ(rows[150].first, kSide);
    EXPECT_EQ(rows[150].last, -1);
    EXPECT_EQ(rows[150].depth_square_sum, 0U);
    mask.assign(mask.size(), 255);
  }
}

}  // namespace
}  // namespace im2fit
