// SPDX-License-Identifier: Apache-2.0
#include "kernels/unproject/unproject.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/rng.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

class Unproject : public testing::TestWithParam<UnprojectKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Unproject, testing::ValuesIn(kUnprojectWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(Unproject, FollowsThePinholeFormula) {
  const Intrinsics k = {64, 48, 57.5F, 56.25F, 30.2F, 25.9F};
  for (const int bits : {0, 4}) {
    std::vector<std::uint16_t> pixels(70 * 48);
    Rng rng(2);
    for (auto& p : pixels) p = static_cast<std::uint16_t>(rng.index(bits == 0 ? 16000 : 65536));
    for (int i = 0; i < 40; ++i) pixels[static_cast<std::size_t>(i * 71)] = 0;
    const DepthView depth(pixels.data(), 64, 48, 70);
    RayTable rays(64, 48);
    rays.set(k);
    std::vector<float> x(64 * 48), y(64 * 48), z(64 * 48);
    GetParam().function(depth, bits, rays, x.data(), y.data(), z.data());
    std::size_t i = 0;
    for (int v = 0; v < 48; ++v) {
      for (int u = 0; u < 64; ++u, ++i) {
        if (depth.at(u, v) == 0) {
          ASSERT_TRUE(std::isnan(x[i]) && std::isnan(y[i]) && std::isnan(z[i]));
          continue;
        }
        const double mm = bits == 0 ? depth.at(u, v) : depth.at(u, v) / 16.0;
        ASSERT_NEAR(x[i], (u - double{k.cx}) / double{k.fx} * mm, 2e-3) << u << ' ' << v;
        ASSERT_NEAR(y[i], (v - double{k.cy}) / double{k.fy} * mm, 2e-3);
        ASSERT_EQ(z[i], static_cast<float>(mm));
      }
    }
  }
}

TEST(RayTableTest, ExtremesStayInRange) {
  RayTable rays(2048, 2);
  rays.set({2048, 2, 1.0F, 1e6F, 1000.0F, 0.0F});
  const FixedPoint3 p = rays.point(2047, 1, 65535, 0), q = rays.point(0, 1, 65535, 0);
  EXPECT_NEAR(p.x.real(), 65535 * 3.999, 0.01);
  EXPECT_NEAR(q.x.real(), -65535 * 3.999, 0.01);
  EXPECT_NEAR(p.y.real(), 0.065535, 1e-3);
}

}  // namespace
}  // namespace im2fit
