// SPDX-License-Identifier: Apache-2.0
#include "body/params_vector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace im2fit::body {
namespace {

TEST(ParamsVector, LayoutIsAsDocumented) {
  Params p;
  p.gender = 0.1F;
  p.age_years = 42;
  p.muscle = 0.3F;
  p.weight = 0.4F;
  p.height = 0.5F;
  p.proportions = 0.6F;
  p.cup = 0.7F;
  p.firmness = 0.8F;
  p.race = {0.5F, 0.3F, 0.2F};
  p.modifiers = {-0.25F, 1.5F};
  p.warp.values.front() = 0.01F;
  p.warp.values.back() = -0.02F;
  const std::vector<float> packed = pack_params(p, 3);
  EXPECT_THAT(std::vector(packed.begin(), packed.begin() + 14),
              testing::ElementsAre(0.1F, 42, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F, 0.5F, 0.3F, 0.2F, -0.25F, 1.5F, 0));
  ASSERT_EQ(packed.size(), 14 + kWarpCount);
  EXPECT_EQ(packed[14], 0.01F);
  EXPECT_EQ(packed.back(), -0.02F);
  EXPECT_EQ(pack_params(p, 1).size(), params_vector_size(1));
}

}  // namespace
}  // namespace im2fit::body
