// SPDX-License-Identifier: Apache-2.0
#include "kernels/downsample/downsample_box.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::joints {
namespace {

using checkasm::Buffer;

TEST(DownsampleBox, RefChoosesTheFirstMaskedPixelOfABlock) {
  // Two blocks of 2 x 2; the mask hides the first pixel of the second, which has no depth in its second pixel.
  const std::uint16_t depth[] = {7, 8, 5, 0,  //
                                 9, 1, 6, 4};
  const std::uint8_t mask[] = {1, 1, 0, 255,  //
                               1, 1, 1, 1};
  std::uint16_t out[2];
  DownsampleMoments m;
  downsample_box_ref({DepthView(depth, 4, 2), MaskView(mask, 4, 2), 2, 0, 0, 2, 1}, out, m);
  EXPECT_EQ(out[0], 7);
  EXPECT_EQ(out[1], 6);
  EXPECT_EQ(m.count, 2);
  EXPECT_EQ(m.z, 13);
  EXPECT_EQ(m.uz, 6);
  EXPECT_EQ(m.vz, 0);
}

void compare(checkasm::Trial& trial, int width, int height, int step, int u_first, int v_first) {
  IM2FIT_CHECK_PARAMETERS(trial,
                          width << " x " << height << ", step " << step << " from " << u_first << ", " << v_first);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  Buffer<std::uint16_t> depth(pixels, trial.next_end());
  Buffer<std::uint8_t> mask(pixels, trial.next_end());
  trial.fill(depth.span());
  for (std::uint16_t& z : depth.span()) z = trial.rng().index(3) == 0 ? std::uint16_t{0} : z;
  for (std::uint8_t& m : mask.span())
    m = trial.rng().index(2) == 0 ? std::uint8_t{0} : trial.biased<std::uint8_t>(0, 255);
  const DownsampleBox box = {
      DepthView(depth.data(), width, height), MaskView(mask.data(), width, height), step, u_first, v_first,
      (width + step - 1) / step - u_first,    (height + step - 1) / step - v_first};
  const auto count = static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height);
  Buffer<std::uint16_t> want(count, trial.next_end()), got(count, trial.next_end());
  DownsampleMoments expected;
  downsample_box_ref(box, want.data(), expected);
  const auto check = [&](DownsampleBoxFunction* function) {
    got.refill();
    DownsampleMoments found;
    function(box, got.data(), found);
    checkasm::expect_same_bits(want, got);
    EXPECT_EQ(found.count, expected.count);
    EXPECT_EQ(found.z, expected.z);
    EXPECT_EQ(found.uz, expected.uz);
    EXPECT_EQ(found.vz, expected.vz);
  };
  check(downsample_box_portable);
  checkasm::each_simd(kDownsampleBoxKernels, [&](const auto& variant) { check(variant.function); });
}

TEST(DownsampleBox, EveryTierGivesTheSamePicture) {
  checkasm::Trial trial;
  for (const int step : {1, 2, 3})
    for (const int width : checkasm::odd_sizes(75)) compare(trial, width, 1 + width % 5, step, width > 9 * step, 0);
  compare(trial, kDownsampleWidthMax, 2, 1, 0, 1);
  compare(trial, 2 * kDownsampleWidthMax - 1, 3, 2, 0, 0);
}

// The sums' worst case: nothing but the largest depth over the widest box.
TEST(DownsampleBox, WidestAndDeepestBoxFitsTheSums) {
  const std::vector<std::uint16_t> depth(kDownsampleWidthMax, 65535);
  const std::vector<std::uint8_t> mask(kDownsampleWidthMax, 255);
  const DownsampleBox box = {DepthView(depth.data(), kDownsampleWidthMax, 1),
                             MaskView(mask.data(), kDownsampleWidthMax, 1),
                             1,
                             0,
                             0,
                             kDownsampleWidthMax,
                             1};
  std::vector<std::uint16_t> out(kDownsampleWidthMax);
  constexpr std::int64_t kColumns = kDownsampleWidthMax;
  for (const auto& variant : kDownsampleBoxWithRef) {
    if (!tier_available(variant.tier)) continue;
    DownsampleMoments m;
    variant.function(box, out.data(), m);
    EXPECT_EQ(m.z, kColumns * 65535) << variant.name;
    EXPECT_EQ(m.uz, kColumns * (kColumns - 1) / 2 * 65535) << variant.name;
  }
}

}  // namespace
}  // namespace im2fit::joints
