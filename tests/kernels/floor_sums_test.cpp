// SPDX-License-Identifier: Apache-2.0
#include "kernels/floor_sums/floor_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

// A floor 1000 mm under a level camera of 100 px focal length, seen through `step` x `step` cells.
struct Floor {
  static constexpr float kFocal = 100, kHeight = 1000;
  int width, height;
  std::vector<float> ray_x, ray_y, row_up;
  std::vector<FloorCell> cells;

  Floor(int columns, int rows, int step, checkasm::Trial& trial) : width(columns * step), height(rows * step) {
    for (int u = 0; u < width; ++u) ray_x.push_back((static_cast<float>(u) - 17) / kFocal);
    for (int v = 0; v < height; ++v) {
      ray_y.push_back((static_cast<float>(v) + 20) / kFocal);
      row_up.push_back(-ray_y.back());
    }
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        if (trial.rng().index(5) == 0) continue;
        cells.push_back({static_cast<std::uint16_t>(c * step), static_cast<std::uint16_t>(r * step),
                         static_cast<std::uint16_t>(step == 1 ? 1 : 1 + trial.rng().index(2)),
                         trial.between(0.1F, 4.0F)});
      }
    }
  }
  FloorGate gate() const { return {0.0F, kHeight, 12.0F, 0.002F, ray_x.data(), ray_y.data(), row_up.data()}; }
  float depth_at(int v) const { return kHeight / ray_y[static_cast<std::size_t>(v)]; }
};

void fill(const Floor& floor, checkasm::Trial& trial, checkasm::Buffer<std::uint16_t>& depth, int stride) {
  trial.fill(depth.span());
  for (int v = 0; v < floor.height; ++v) {
    for (int u = 0; u < floor.width; ++u) {
      if (trial.rng().index(6) == 0) continue;  // anything, 0 and too far among it
      const float off = trial.between(-60.0F, 60.0F);
      depth[static_cast<std::size_t>(v * stride + u)] = static_cast<std::uint16_t>(floor.depth_at(v) + off);
    }
  }
}

TEST(FloorSums, FindThePlaneTheyAreMadeOf) {
  checkasm::Trial trial;
  const Floor floor(10, 12, 4, trial);
  checkasm::Buffer<std::uint16_t> depth(static_cast<std::size_t>(floor.width * floor.height));
  for (int v = 0; v < floor.height; ++v)
    for (int u = 0; u < floor.width; ++u)
      depth[static_cast<std::size_t>(v * floor.width + u)] =
          static_cast<std::uint16_t>(std::lround(floor.depth_at(v)));
  PlaneSums s;
  floor_sums({depth.data(), floor.width, floor.height}, 4, floor.gate(), floor.cells.data(),
             static_cast<int>(floor.cells.size()), s);
  // q = up / height = (0, -1/1000, 0) solves the equations, to the rounding of depths to millimetres.
  const double q = -1.0 / 1000;
  EXPECT_NEAR(s.a[1] * q, s.b[0], 2e-4 * std::fabs(s.b[2]));
  EXPECT_NEAR(s.a[3] * q, s.b[1], 2e-4 * std::fabs(s.b[1]));
  EXPECT_NEAR(s.a[4] * q, s.b[2], 2e-4 * std::fabs(s.b[2]));
  double weight = 0;
  for (const FloorCell& c : floor.cells) weight += static_cast<double>(c.weight) * (c.stride == 1 ? 16 : 4);
  EXPECT_NEAR(s.weight, weight, 1e-9 * weight);
}

TEST(FloorSums, TenMetresCountAndNoMillimetreMore) {
  const float ray = 0;
  const FloorCell cell = {0, 0, 1, 1.0F};
  const FloorGate gate = {0.0F, 0.0F, 1e9F, 0.0F, &ray, &ray, &ray};
  for (const auto& variant : kFloorSumsWithRef) {
    if (!tier_available(variant.tier)) continue;
    for (const auto& [depth, weight] : {std::pair{std::uint16_t{10000}, 1.0}, {std::uint16_t{10001}, 0.0}}) {
      PlaneSums sums;
      variant.function({&depth, 1, 1}, 1, gate, &cell, 1, sums);
      EXPECT_EQ(sums.weight, weight) << variant.name << " at " << depth;
    }
  }
}

TEST(FloorSumsCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (const int step : {1, 2, 3, 4, 5}) {
    for (int repeat = 0; repeat < 12; ++repeat) {
      const Floor floor(1 + trial.rng().index(8), 1 + trial.rng().index(5), step, trial);
      const int stride = floor.width + trial.rng().index(3);
      IM2FIT_CHECK_PARAMETERS(trial, step << ", repeat " << repeat);
      checkasm::Buffer<std::uint16_t> depth(static_cast<std::size_t>((floor.height - 1) * stride + floor.width),
                                            trial.next_end());
      fill(floor, trial, depth, stride);
      const DepthView view(depth.data(), floor.width, floor.height, stride);
      const int count = static_cast<int>(floor.cells.size());
      PlaneSums ref, want, got;
      floor_sums_ref(view, step, floor.gate(), floor.cells.data(), count, ref);
      floor_sums_portable(view, step, floor.gate(), floor.cells.data(), count, want);
      // Rays are below 1 here and inverse depths below 1e-3: sums of magnitudes are at most weight and 1e-3 weight.
      for (int k = 0; k < 6; ++k) EXPECT_NEAR(want.a[k], ref.a[k], 1e-5 * ref.weight) << k;
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(want.b[k], ref.b[k], 1e-8 * ref.weight) << k;
      EXPECT_NEAR(want.weight, ref.weight, 1e-12 * ref.weight);
      checkasm::each_simd(kFloorSumsKernels, [&](const auto& variant) {
        variant.function(view, step, floor.gate(), floor.cells.data(), count, got);
        EXPECT_EQ(std::memcmp(&want, &got, sizeof want), 0);
      });
    }
  }
}

}  // namespace
}  // namespace im2fit
