// SPDX-License-Identifier: Apache-2.0
#include "kernels/project/project.h"

#include <limits>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using checkasm::Buffer;

constexpr std::int16_t kFeatureMax = kStandardFeatureRawMax;

TEST(Standardise, RefOnValuesDoneByHand) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const float feature[] = {3, 1, nan, 100, -inf, 7, inf};
  const float mean[] = {1, 1, 0, 0, 5, 5, 5};
  const float scale[] = {0.5F, 9, 1, 1, 2, 0, 0};
  std::int16_t out[7];
  standardise_ref(feature, mean, scale, 7, out);
  EXPECT_EQ(out[0], 4096);      // one standard deviation
  EXPECT_EQ(out[1], 0);         // the mean
  EXPECT_EQ(out[2], 0);         // not measured
  EXPECT_EQ(out[3], 5 * 4096);  // clipped
  EXPECT_EQ(out[4], -5 * 4096);
  EXPECT_EQ(out[5], 0);  // a feature that never varied
  EXPECT_EQ(out[6], 0);
}

TEST(Standardise, PortableIsWithinAStepOfRef) {
  checkasm::Trial trial;
  const float inf = std::numeric_limits<float>::infinity();
  for (int count : checkasm::odd_sizes(70)) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    const auto n = static_cast<std::size_t>(count);
    Buffer<float> feature(n, trial.next_end()), mean(n, trial.next_end()), scale(n, trial.next_end());
    trial.fill(mean.span(), -100, 100);
    for (std::size_t i = 0; i < n; ++i) {
      const float special[] = {0, 1e9F, 1e-30F, 1, 0.37F};
      scale[i] = i % 9 < 5 ? special[i % 9] : trial.between(1e-3F, 10);
      const float reach = scale[i] > 1e-3F ? 6 / scale[i] : 1;
      feature[i] = mean[i] + trial.between(-reach, reach);
      // Denormals, infinities, no numbers, and ties: half steps.
      switch (trial.rng().index(12)) {
        case 0:
          feature[i] = std::numeric_limits<float>::quiet_NaN();
          break;
        case 1:
          feature[i] = i % 2 == 0 ? inf : -inf;
          break;
        case 2:
          feature[i] = 1e-40F, mean[i] = i % 2 == 0 ? 0.0F : 3e-41F;
          break;
        case 3:
          mean[i] = 0, scale[i] = 1;
          feature[i] = (static_cast<float>(trial.rng().index(40000) - 20000) + 0.5F) / 4096;
          break;
        default:
          break;
      }
    }
    Buffer<std::int16_t> truth(n), want(n, trial.next_end());
    standardise_ref(feature.data(), mean.data(), scale.data(), count, truth.data());
    standardise_portable(feature.data(), mean.data(), scale.data(), count, want.data());
    for (std::size_t i = 0; i < n; ++i)
      ASSERT_LE(std::abs(truth[i] - want[i]), 1) << feature[i] << " " << mean[i] << " " << scale[i];
  }
}

TEST(Project, RefAddsProducts) {
  std::vector<std::int16_t> feature(kProjectBlock), weights(2 * kProjectBlock);
  feature[0] = 3;
  feature[15] = -20480;
  weights[0] = 5;
  weights[15] = 32767;
  weights[16] = -7;
  std::int64_t out[2];
  project_ref(feature.data(), weights.data(), kProjectBlock, 2, out);
  EXPECT_EQ(out[0], 15 - 20480LL * 32767);
  EXPECT_EQ(out[1], -21);
}

TEST(Project, EveryTierGivesTheSameSums) {
  checkasm::Trial trial;
  for (int stride = kProjectBlock; stride <= 12 * kProjectBlock; stride += kProjectBlock) {
    for (const int rows : {1, 2, 3, 16}) {
      IM2FIT_CHECK_PARAMETERS(trial, stride << " x " << rows);
      Buffer<std::int16_t> feature(static_cast<std::size_t>(stride), trial.next_end());
      Buffer<std::int16_t> weights(static_cast<std::size_t>(stride * rows), trial.next_end());
      trial.fill(feature.span(), static_cast<std::int16_t>(-kFeatureMax), kFeatureMax);
      trial.fill<std::int16_t>(weights.span(), -32767, 32767);
      Buffer<std::int64_t> want(static_cast<std::size_t>(rows), trial.next_end()), got(want.size(), trial.next_end());
      project_ref(feature.data(), weights.data(), stride, rows, want.data());
      project_portable(feature.data(), weights.data(), stride, rows, got.data());
      checkasm::expect_same_bits(want, got);
    }
  }
}

// Every product the largest there is, of either sign, over the longest feature.
TEST(Project, LargestSumsFit) {
  constexpr int kStride = 1 << 18;
  std::vector<std::int16_t> feature(kStride, kFeatureMax), weights(2 * kStride, 32767);
  std::fill(weights.begin() + kStride, weights.end(), std::int16_t{-32767});
  const std::int64_t expected = std::int64_t{kStride} * kFeatureMax * 32767;
  for (const auto& variant : kProjectWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::int64_t out[2];
    variant.function(feature.data(), weights.data(), kStride, 2, out);
    EXPECT_EQ(out[0], expected) << variant.name;
    EXPECT_EQ(out[1], -expected) << variant.name;
  }
}

}  // namespace
}  // namespace im2fit
