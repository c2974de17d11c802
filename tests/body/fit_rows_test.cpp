// SPDX-License-Identifier: Apache-2.0
// The fit's innermost loops against the same sums written value by value: every variant, every bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "body/fit/rows.h"
#include "core/rng.h"

namespace im2fit::body {
namespace {

std::vector<const FitLoops*> variants() {
  return {&kFitLoopsPortable, &fit_loops()};
}

std::vector<float> random_values(Rng& rng, std::size_t count, double size) {
  std::vector<float> out(count);
  for (float& v : out) v = static_cast<float>(rng.uniform(-size, size));
  return out;
}

TEST(FitRows, SumsAreThoseOfEachValueAlone) {
  Rng rng(7);
  for (int trial = 0; trial < 60; ++trial) {
    const auto width = static_cast<std::size_t>(1 + rng.index(70));
    const std::size_t stride = whole_lanes(width) + static_cast<std::size_t>(rng.index(5));
    const auto rows = random_values(rng, kRowGroup * stride, 3);
    const auto weight = random_values(rng, kRowGroup, 2), residual = random_values(rng, kRowGroup, 40);
    const auto before = random_values(rng, width * stride, 5);
    const auto slope = [&](std::size_t r, std::size_t c) { return rows[r * stride + c]; };
    for (const FitLoops* loops : variants()) {
      std::vector<float> sums = before;
      std::vector<double> right(width, 0.25);
      loops->sum_rows({rows.data(), stride, width, weight.data(), residual.data()}, sums.data(), right.data());
      for (std::size_t i = 0; i < width; ++i) {
        for (std::size_t c = i; c < width; ++c) {
          std::array<float, kRowGroup> p{};
          for (std::size_t r = 0; r < kRowGroup; ++r) p[r] = weight[r] * slope(r, i) * slope(r, c);
          const float sum = ((p[0] + p[1]) + (p[2] + p[3])) + ((p[4] + p[5]) + (p[6] + p[7]));
          ASSERT_EQ(sums[i * stride + c], before[i * stride + c] + sum) << "trial " << trial << ": " << i << ' ' << c;
        }
        for (std::size_t c = 0; c < i - i % kRowLanes; ++c) ASSERT_EQ(sums[i * stride + c], before[i * stride + c]);
        for (std::size_t c = whole_lanes(width); c < stride; ++c)
          ASSERT_EQ(sums[i * stride + c], before[i * stride + c]);
        double expected = 0.25;
        for (std::size_t r = 0; r < kRowGroup; ++r)
          expected +=
              static_cast<double>(weight[r]) * static_cast<double>(residual[r]) * static_cast<double>(slope(r, i));
        ASSERT_EQ(right[i], expected) << "trial " << trial << ": " << i;
      }
    }
  }
}

TEST(FitRows, SlopesAreThoseOfEachCoefficientAlone) {
  Rng rng(8);
  for (int trial = 0; trial < 60; ++trial) {
    const auto count = static_cast<std::size_t>(1 + rng.index(64));
    const std::size_t parts = 1 + static_cast<std::size_t>(trial) % kPartsMax;
    std::vector<std::vector<float>> rows;
    SlopeParts wanted{{}, {}, parts, count};
    for (std::size_t p = 0; p < parts; ++p) {
      rows.push_back(random_values(rng, 3 * count, 20));
      for (float& n : wanted.along[p]) n = static_cast<float>(rng.uniform(-1, 1));
    }
    for (std::size_t p = 0; p < parts; ++p) wanted.rows[p] = rows[p].data();
    for (const FitLoops* loops : variants()) {
      std::vector<float> out(count, 99);
      loops->add_slopes(wanted, out.data());
      for (std::size_t k = 0; k < count; ++k) {
        float expected = 0;
        for (std::size_t p = 0; p < parts; ++p) {
          const auto& n = wanted.along[p];
          const float slope = n[0] * rows[p][k] + n[1] * rows[p][count + k] + n[2] * rows[p][2 * count + k];
          expected = p == 0 ? slope : expected + slope;
        }
        ASSERT_EQ(out[k], expected) << "trial " << trial << ": " << k;
      }
    }
  }
}

TEST(FitRows, ShapesAreThoseOfEachValueAlone) {
  Rng rng(9);
  for (int trial = 0; trial < 60; ++trial) {
    const auto shapes = static_cast<std::size_t>(1 + rng.index(64)), values = static_cast<std::size_t>(rng.index(40));
    const auto mean = random_values(rng, values, 900), basis = random_values(rng, values * shapes, 20);
    const auto c = random_values(rng, shapes, 3);
    for (const FitLoops* loops : variants()) {
      std::vector<float> out(values + 1, 99);
      loops->add_shapes({mean.data(), basis.data(), c.data(), values, shapes}, out.data());
      for (std::size_t i = 0; i < values; ++i) {
        std::array<float, 4> sum = {mean[i], 0, 0, 0};
        for (std::size_t k = 0; k < shapes; ++k) sum[k < shapes / 4 * 4 ? k % 4 : 0] += basis[i * shapes + k] * c[k];
        ASSERT_EQ(out[i], (sum[0] + sum[1]) + (sum[2] + sum[3])) << "trial " << trial << ": " << i;
      }
      ASSERT_EQ(out[values], 99);
    }
  }
}

TEST(FitRows, PivotsAreTakenOneAfterAnother) {
  Rng rng(10);
  for (int trial = 0; trial < 60; ++trial) {
    const auto size = static_cast<std::size_t>(2 + rng.index(70));
    const auto below = [&](std::size_t end) { return static_cast<std::size_t>(rng.index(static_cast<int>(end))); };
    const std::size_t row = 1 + below(size - 1), first = below(row + 1), from = below(size + 1);
    const std::size_t to = from + below(size + 1 - from);
    std::vector<double> before(size * size);
    for (double& v : before) v = rng.uniform(-2, 2);
    std::vector<double> expected = before;
    for (std::size_t c = from; c < to; ++c)
      for (std::size_t k = first; k < row; ++k)
        expected[row * size + c] -= before[k * size + row] * before[k * size + c];
    for (const FitLoops* loops : variants()) {
      std::vector<double> matrix = before;
      loops->take_pivots({matrix.data(), size, row, first, row, from, to});
      ASSERT_EQ(matrix, expected) << "trial " << trial;
    }
  }
}

}  // namespace
}  // namespace im2fit::body
