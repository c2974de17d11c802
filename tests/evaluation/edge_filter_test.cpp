// SPDX-License-Identifier: Apache-2.0
// What drivers do beside edges, by the sums written down here.
#include "evaluation/measurements/edge_filter.h"

#include <gtest/gtest.h>

#include <vector>

namespace im2fit::lab {
namespace {

using Row = std::vector<std::uint16_t>;

// The middle row of a picture whose rows are all alike.
Row filtered(const Row& row, const EdgeFilterOptions& options) {
  constexpr int kHeight = 9;
  const int width = static_cast<int>(row.size());
  std::vector<std::uint16_t> pixels;
  for (int v = 0; v < kHeight; ++v) pixels.insert(pixels.end(), row.begin(), row.end());
  EdgeFilter(options).run({pixels.data(), width, kHeight});
  const auto middle = pixels.begin() + kHeight / 2 * width;
  return {middle, middle + width};
}

const Row kStep = {2000, 2000, 2000, 2000, 2000, 2600, 2600, 2600, 2600, 2600};

TEST(EdgeFilter, MeansBridgeASurfaceToTheOther) {
  EXPECT_EQ(filtered(kStep, {}), kStep);
  EXPECT_EQ(filtered(kStep, {EdgeBlend::mean3}), (Row{2000, 2000, 2000, 2000, 2200, 2400, 2600, 2600, 2600, 2600}));
  EXPECT_EQ(filtered(kStep, {EdgeBlend::mean5}), (Row{2000, 2000, 2000, 2120, 2240, 2360, 2480, 2600, 2600, 2600}));
}

TEST(EdgeFilter, ABilateralFilterKeepsASharpStep) {
  const Row kept = filtered(kStep, {EdgeBlend::bilateral5});
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_NEAR(kept[i], kStep[i], 1) << i;
}

TEST(EdgeFilter, HalfTheResolutionMeetsHalfway) {
  EXPECT_EQ(filtered(kStep, {EdgeBlend::bilinear2}),
            (Row{2000, 2000, 2000, 2000, 2000, 2300, 2600, 2600, 2600, 2600}));
}

TEST(EdgeFilter, NoDataStaysAndIsNotBlended) {
  Row step = kStep;
  step[5] = 0;
  EXPECT_EQ(filtered(step, {EdgeBlend::mean3}), (Row{2000, 2000, 2000, 2000, 2000, 0, 2600, 2600, 2600, 2600}));
}

TEST(EdgeFilter, LowConfidenceIsAPixelOnEitherSide) {
  EXPECT_EQ(filtered(kStep, {EdgeBlend::none, true}), (Row{2000, 2000, 2000, 2000, 0, 0, 2600, 2600, 2600, 2600}));
  EXPECT_EQ(filtered({2000, 2000, 2090, 2090, 2090}, {EdgeBlend::none, true}), (Row{2000, 2000, 2090, 2090, 2090}));
}

}  // namespace
}  // namespace im2fit::lab
