// SPDX-License-Identifier: Apache-2.0
#include "kernels/sample/sample.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

class Sample : public testing::TestWithParam<SampleKernel> {
 protected:
  // One cell of 4 x 4 with these five samples; the eleven pixels not sampled hold nonsense.
  std::uint16_t cell(std::array<std::uint16_t, 5> samples) const {
    std::vector<std::uint16_t> pixels(16, 3);
    const std::array<std::size_t, 5> at = {0, 3, 10, 12, 15};
    for (std::size_t i = 0; i < at.size(); ++i) pixels[at[i]] = samples[i];
    std::uint16_t out = 7;
    GetParam().function({pixels.data(), 4, 4}, 4, &out);
    return out;
  }
};
INSTANTIATE_TEST_SUITE_P(Tiers, Sample, testing::ValuesIn(kSampleWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(Sample, TakesTheLowerMedianOfWhatIsSeen) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  EXPECT_EQ(cell({5, 1, 4, 2, 3}), 3);
  EXPECT_EQ(cell({5, 0, 4, 2, 3}), 3);          // of 2 3 4 5
  EXPECT_EQ(cell({65535, 10001, 9, 2, 3}), 3);  // of 2 3 9
  EXPECT_EQ(cell({10000, 0, 0, 9000, 0}), 9000);
  EXPECT_EQ(cell({0, 0, 10000, 0, 0}), 10000);
  EXPECT_EQ(cell({0, 10001, 0, 32768, 65535}), 0);
}

TEST(SampleCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (const int step : {1, 2, 3, 4, 5, 7}) {
    for (const int cells : checkasm::odd_sizes(70)) {
      const int width = cells * step + trial.rng().index(step), height = 2 * step + trial.rng().index(step);
      const int stride = width + trial.rng().index(5);
      IM2FIT_CHECK_PARAMETERS(trial, step << ", width " << width << ", height " << height << ", stride " << stride);
      const auto pixels = static_cast<std::size_t>((height - 1) * stride + width);
      checkasm::Buffer<std::uint16_t> in(pixels, trial.next_end());
      checkasm::Buffer<std::uint16_t> want(static_cast<std::size_t>(cells * (height / step)), trial.next_end()),
          got(want.size(), trial.next_end());
      trial.fill(in.span(), std::uint16_t{0}, static_cast<std::uint16_t>(trial.rng().index(2) == 0 ? 10010 : 65535));
      const DepthView view(in.data(), width, height, stride);
      sample_ref(view, step, want.data());
      sample_portable(view, step, got.data());
      checkasm::expect_same_bits(want, got);
      checkasm::each_simd(kSampleKernels, [&](const auto& variant) {
        got.refill();
        variant.function(view, step, got.data());
        checkasm::expect_same_bits(want, got);
      });
    }
  }
}

}  // namespace
}  // namespace im2fit
