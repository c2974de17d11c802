// SPDX-License-Identifier: Apache-2.0
#include "kernels/silhouette/silhouette.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void PrintTo(const Silhouette& s, std::ostream* out) {
  *out << s.count << " px, box " << s.u_min << ' ' << s.v_min << ' ' << s.u_max << ' ' << s.v_max << ", sums "
       << s.sum_z << ' ' << s.sum_uz << ' ' << s.sum_vz;
}

namespace {

class SilhouetteTiers : public testing::TestWithParam<SilhouetteKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, SilhouetteTiers, testing::ValuesIn(kSilhouetteWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

// A full rectangle of even depth has its sums in closed form.
TEST_P(SilhouetteTiers, RectangleInClosedForm) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  constexpr int kWidth = 90, kHeight = 30, kLeft = 13, kRight = 77, kTop = 4, kBottom = 21;
  constexpr std::uint64_t kDepth = 3000;
  std::vector<std::uint16_t> depth(kWidth * kHeight, 9999);
  std::vector<std::uint8_t> mask(depth.size());
  for (int v = kTop; v <= kBottom; ++v) {
    for (int u = kLeft; u <= kRight; ++u) {
      depth[static_cast<std::size_t>(v * kWidth + u)] = kDepth;
      mask[static_cast<std::size_t>(v * kWidth + u)] = 255;
    }
  }
  constexpr int kColumns = kRight - kLeft + 1, kRows = kBottom - kTop + 1;
  Silhouette got;
  GetParam().function({depth.data(), kWidth, kHeight}, {mask.data(), kWidth, kHeight}, got);
  const Silhouette want = {kColumns * kRows,
                           kLeft,
                           kRight,
                           kTop,
                           kBottom,
                           kColumns * kRows * kDepth,
                           kRows * kColumns * (kLeft + kRight) / 2 * kDepth,
                           kColumns * kRows * (kTop + kBottom) / 2 * kDepth};
  EXPECT_EQ(got, want);
  std::fill(mask.begin(), mask.end(), std::uint8_t{0});
  GetParam().function({depth.data(), kWidth, kHeight}, {mask.data(), kWidth, kHeight}, got);
  EXPECT_EQ(got, Silhouette{});
}

TEST(SilhouetteCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  std::vector<int> widths = checkasm::odd_sizes(80);
  widths.push_back(kImageSideMax - 1);
  for (const int width : widths) {
    const int height = 5, z_stride = width + trial.rng().index(4), m_stride = width + trial.rng().index(4);
    IM2FIT_CHECK_PARAMETERS(trial, width << ", strides " << z_stride << ' ' << m_stride);
    checkasm::Buffer<std::uint16_t> z(static_cast<std::size_t>((height - 1) * z_stride + width), trial.next_end());
    checkasm::Buffer<std::uint8_t> m(static_cast<std::size_t>((height - 1) * m_stride + width), trial.next_end());
    trial.fill(z.span(), std::uint16_t{0}, std::uint16_t{32767});
    const int share = trial.rng().index(4);  // none, few, most, all
    for (std::size_t i = 0; i < m.size(); ++i) {
      const int draw = trial.rng().index(16);
      m[i] = share == 3 || (share == 2 && draw > 0) || (share == 1 && draw == 0) ? 255 : 0;
    }
    if (share == 3 && trial.rng().index(2) == 0)
      for (std::size_t i = 0; i < z.size(); ++i) z[i] = 32767;  // the sums at their largest
    const DepthView depth(z.data(), width, height, z_stride);
    const MaskView mask(m.data(), width, height, m_stride);
    Silhouette want, got;
    silhouette_ref(depth, mask, want);
    silhouette_portable(depth, mask, got);
    EXPECT_EQ(want, got);
    checkasm::each_simd(kSilhouetteKernels, [&](const auto& variant) {
      variant.function(depth, mask, got);
      EXPECT_EQ(want, got);
    });
  }
}

}  // namespace
}  // namespace im2fit
