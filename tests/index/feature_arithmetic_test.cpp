// SPDX-License-Identifier: Apache-2.0
// The arithmetic over a feature and over the neighbours of a query, against double and by hand. This file needs no
// index, so it is built for the device, too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "index/regression.h"
#include "tests/kernels/checkasm.h"

namespace im2fit::index {
namespace {

using checkasm::Buffer;

constexpr std::int16_t kFeatureMax = kStandardFeatureRawMax;

TEST(Standardise, ValuesDoneByHand) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const float feature[] = {3, 1, nan, 100, -inf, 7, inf};
  const float mean[] = {1, 1, 0, 0, 5, 5, 5};
  const float scale[] = {0.5F, 9, 1, 1, 2, 0, 0};
  std::int16_t out[7];
  standardise(feature, mean, scale, 7, out);
  EXPECT_EQ(out[0], 4096);      // one standard deviation
  EXPECT_EQ(out[1], 0);         // the mean
  EXPECT_EQ(out[2], 0);         // not measured
  EXPECT_EQ(out[3], 5 * 4096);  // clipped
  EXPECT_EQ(out[4], -5 * 4096);
  EXPECT_EQ(out[5], 0);  // a feature that never varied
  EXPECT_EQ(out[6], 0);
}

std::int16_t standardised_in_double(double feature, double mean, double scale) {
  constexpr double kMax = kStandardFeatureMax;
  const double z = (feature - mean) * scale;
  return static_cast<std::int16_t>(std::isnan(z) ? 0 : std::lround(4096 * std::clamp(z, -kMax, kMax)));
}

// Both are rounded, and two roundings of float32 below 8 (2^-21) may tip one of them over.
TEST(Standardise, IsWithinAStepOfDouble) {
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
    Buffer<std::int16_t> got(n, trial.next_end());
    standardise(feature.data(), mean.data(), scale.data(), count, got.data());
    for (std::size_t i = 0; i < n; ++i) {
      const std::int16_t truth = standardised_in_double(double{feature[i]}, double{mean[i]}, double{scale[i]});
      ASSERT_LE(std::abs(truth - got[i]), 1) << feature[i] << " " << mean[i] << " " << scale[i];
    }
  }
}

TEST(MultiplyRows, AddsProducts) {
  std::vector<std::int16_t> feature(kRowBlock), weights(2 * kRowBlock);
  feature[0] = 3;
  feature[15] = -20480;
  weights[0] = 5;
  weights[15] = 32767;
  weights[16] = -7;
  std::int64_t out[2];
  multiply_rows(feature.data(), weights.data(), kRowBlock, 2, out);
  EXPECT_EQ(out[0], 15 - 20480LL * 32767);
  EXPECT_EQ(out[1], -21);
}

// Whole numbers below 2^53: exact.
std::int64_t sum_in_double(const std::int16_t* feature, const std::int16_t* weights, int count) {
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += static_cast<double>(feature[i]) * static_cast<double>(weights[i]);
  return static_cast<std::int64_t>(sum);
}

TEST(MultiplyRows, IsExact) {
  checkasm::Trial trial;
  for (int stride = kRowBlock; stride <= 12 * kRowBlock; stride += kRowBlock) {
    for (const int rows : {1, 2, 3, 16}) {
      IM2FIT_CHECK_PARAMETERS(trial, stride << " x " << rows);
      Buffer<std::int16_t> feature(static_cast<std::size_t>(stride), trial.next_end());
      Buffer<std::int16_t> weights(static_cast<std::size_t>(stride * rows), trial.next_end());
      trial.fill(feature.span(), static_cast<std::int16_t>(-kFeatureMax), kFeatureMax);
      trial.fill<std::int16_t>(weights.span(), -32767, 32767);
      Buffer<std::int64_t> got(static_cast<std::size_t>(rows), trial.next_end());
      multiply_rows(feature.data(), weights.data(), stride, rows, got.data());
      for (int r = 0; r < rows; ++r)
        ASSERT_EQ(got[static_cast<std::size_t>(r)],
                  sum_in_double(feature.data(), weights.data() + std::ptrdiff_t{r} * stride, stride));
    }
  }
}

// Every product the largest there is, of either sign, over the longest feature.
TEST(MultiplyRows, LargestSumsFit) {
  constexpr int kStride = 1 << 18;
  std::vector<std::int16_t> feature(kStride, kFeatureMax), weights(2 * kStride, 32767);
  std::fill(weights.begin() + kStride, weights.end(), std::int16_t{-32767});
  const std::int64_t expected = std::int64_t{kStride} * kFeatureMax * 32767;
  std::int64_t out[2];
  multiply_rows(feature.data(), weights.data(), kStride, 2, out);
  EXPECT_EQ(out[0], expected);
  EXPECT_EQ(out[1], -expected);
}

TEST(AddGram, TwoRowsDoneByHand) {
  std::vector<double> rows(2 * kGramWidth), sums(kGramWidth), products(kGramWidth * kGramWidth);
  rows[0] = 2, rows[1] = 3;
  rows[kGramWidth] = -1, rows[kGramWidth + 1] = 5;
  const double weights[] = {10, 1};
  products[kGramWidth] = 100;
  add_gram(rows.data(), weights, 2, 2, sums.data(), products.data());
  EXPECT_EQ(sums[0], 19);
  EXPECT_EQ(sums[1], 35);
  EXPECT_EQ(products[0], 41);
  EXPECT_EQ(products[kGramWidth], 100 + 60 - 5);
  EXPECT_EQ(products[kGramWidth + 1], 115);
}

// X' W X in long double, added to `sums`.
void add_gram_in_long_double(const double* rows, const double* weights, int count, int used, double* sums,
                             double* products) {
  using Wide = long double;
  for (int i = 0; i < used; ++i) {
    Wide sum = 0;
    for (int n = 0; n < count; ++n) sum += Wide{weights[n]} * Wide{rows[n * kGramWidth + i]};
    sums[i] += static_cast<double>(sum);
    for (int j = 0; j <= i; ++j) {
      Wide product = 0;
      for (int n = 0; n < count; ++n)
        product += Wide{weights[n]} * Wide{rows[n * kGramWidth + i]} * Wide{rows[n * kGramWidth + j]};
      products[i * kGramWidth + j] += static_cast<double>(product);
    }
  }
}

// Within count * 2^-52 of the sum of the terms' magnitudes, which are below 1.
TEST(AddGram, IsCloseToLongDouble) {
  checkasm::Trial trial;
  for (int used = 0; used <= kGramWidth; ++used) {
    for (const int count : {0, 1, 2, 7, 32}) {
      IM2FIT_CHECK_PARAMETERS(trial, used << " columns, " << count << " rows");
      constexpr std::size_t kSize = kGramWidth * kGramWidth;
      Buffer<double> rows(static_cast<std::size_t>(count * kGramWidth), trial.next_end());
      Buffer<double> weights(static_cast<std::size_t>(count), trial.next_end());
      for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = static_cast<int>(i % kGramWidth) < used ? trial.rng().uniform(-1, 1) : 0.0;
      for (double& w : weights.span()) w = trial.rng().uniform();
      struct Result {
        Buffer<double> sums, products;
        explicit Result(checkasm::Guard end) : sums(kGramWidth, end), products(kSize, end) {
          for (double& v : sums.span()) v = 0.25;
          for (double& v : products.span()) v = 0.5;
        }
      };
      Result truth(trial.next_end()), got(trial.next_end());
      add_gram_in_long_double(rows.data(), weights.data(), count, used, truth.sums.data(), truth.products.data());
      add_gram(rows.data(), weights.data(), count, used, got.sums.data(), got.products.data());
      const double tolerance = (count + 1) * (count + 1.0) * 0x1p-52;
      for (std::size_t i = 0; i < static_cast<std::size_t>(used); ++i) {
        ASSERT_LE(std::abs(truth.sums[i] - got.sums[i]), tolerance) << "sum " << i;
        for (std::size_t j = 0; j <= i; ++j)
          ASSERT_LE(std::abs(truth.products[i * kGramWidth + j] - got.products[i * kGramWidth + j]), tolerance)
              << "product " << i << ", " << j;
      }
    }
  }
}

}  // namespace
}  // namespace im2fit::index
