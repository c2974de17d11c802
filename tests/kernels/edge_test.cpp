// SPDX-License-Identifier: Apache-2.0
#include "kernels/edge/edge.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"

namespace im2fit {
namespace {

class Edge : public testing::TestWithParam<EdgeKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Edge, testing::ValuesIn(kEdgeKernels),
                         [](const auto& p) { return std::string(p.param.name); });

// A step from 2000 to 2000 + `rise` mm between columns 19 and 20, one pixel alone in a hole, one flying.
TEST_P(Edge, MarksBothSidesOfAStepAndWhatStandsAlone) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  constexpr int kWidth = 40, kHeight = 20;
  // 40 + 1.5 x 2.85e-6 x 2000^2 = 57.1 mm; the nearer side's limit is the tighter one.
  for (const int rise : {0, 56, 57, 59, 300}) {
    std::vector<std::uint16_t> z(kWidth * kHeight);
    const auto at = [](int u, int v) { return static_cast<std::size_t>(v * kWidth + u); };
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) z[at(u, v)] = static_cast<std::uint16_t>(u < 20 ? 2000 : 2000 + rise);
    for (int v = 4; v <= 6; ++v)
      for (int u = 4; u <= 6; ++u) z[at(u, v)] = u == 5 && v == 5 ? 2000 : 0;
    z[at(10, 12)] = 2200;
    std::vector<std::uint8_t> mask(z.size(), 7);
    GetParam().function({z.data(), kWidth, kHeight}, {mask.data(), kWidth, kHeight});
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const bool step = rise > 57 && (u == 19 || u == 20), alone = u == 5 && v == 5;
        const bool flying = std::abs(u - 10) + std::abs(v - 12) <= 1;  // and its four neighbours
        ASSERT_EQ(mask[at(u, v)], step || alone || flying ? 255 : 0) << rise << ": " << u << ' ' << v;
      }
    }
  }
}

TEST(EdgeCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (const int width : checkasm::odd_sizes(60)) {
    const int height = 1 + trial.rng().index(6);
    const int z_stride = width + trial.rng().index(3), m_stride = width + trial.rng().index(3);
    IM2FIT_CHECK_PARAMETERS(trial, width << 'x' << height << ", strides " << z_stride << ' ' << m_stride);
    checkasm::Buffer<std::uint16_t> z(static_cast<std::size_t>((height - 1) * z_stride + width), trial.next_end());
    if (trial.rng().index(2) == 0)
      trial.fill(z.span());
    else
      trial.fill(z.span(), std::uint16_t{3000}, std::uint16_t{3100});
    for (std::size_t i = 0; i < z.size(); ++i)
      if (trial.rng().index(6) == 0) z[i] = 0;
    const auto size = static_cast<std::size_t>((height - 1) * m_stride + width);
    checkasm::Buffer<std::uint8_t> want(size, trial.next_end()), got(size, trial.next_end());
    const DepthView depth(z.data(), width, height, z_stride);
    edge_ref(depth, {want.data(), width, height, m_stride});
    edge_portable(depth, {got.data(), width, height, m_stride});
    checkasm::expect_same_bits(want, got);
    checkasm::each_simd(kEdgeKernels, [&](const auto& variant) {
      got.refill();
      variant.function(depth, {got.data(), width, height, m_stride});
      checkasm::expect_same_bits(want, got);
    });
  }
}

}  // namespace
}  // namespace im2fit
