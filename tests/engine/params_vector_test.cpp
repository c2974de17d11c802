// SPDX-License-Identifier: Apache-2.0
#include "body/params_vector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

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
  EXPECT_THAT(pack_params(p, 3),
              testing::ElementsAre(0.1F, 42, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F, 0.5F, 0.3F, 0.2F, -0.25F, 1.5F, 0));
  EXPECT_EQ(pack_params(p, 1).size(), params_vector_size(1));
}

TEST(ParamsVector, UnpackGivesBackWhatWasPacked) {
  Params p;
  p.gender = 1;
  p.age_years = 63.5F;
  p.race = {0.25F, 0.25F, 0.5F};
  p.modifiers = {0.125F, -2, 0};
  auto q = unpack_params(pack_params(p, 3), 3);
  ASSERT_TRUE(q);
  EXPECT_EQ(pack_params(*q, 3), pack_params(p, 3));
}

TEST(ParamsVector, QuantisedValuesAreBroughtIntoRange) {
  std::vector<float> row = pack_params(Params{}, 0);
  row[0] = 1.00001F;
  row[1] = 17.9F;
  row[2] = -0.00001F;
  row[8] = row[9] = row[10] = 0.4F;
  auto p = unpack_params(row, 0);
  ASSERT_TRUE(p);
  EXPECT_EQ(p->gender, 1.0F);
  EXPECT_EQ(p->age_years, 18.0F);
  EXPECT_EQ(p->muscle, 0.0F);
  EXPECT_NEAR(p->race[0] + p->race[1] + p->race[2], 1, 1e-6);
}

TEST(ParamsVector, RefusesForeignRows) {
  EXPECT_FALSE(unpack_params(pack_params(Params{}, 4), 5));
  EXPECT_FALSE(unpack_params({}, 0));
  std::vector<float> row = pack_params(Params{}, 2);
  row[12] = std::numeric_limits<float>::quiet_NaN();
  auto p = unpack_params(row, 2);
  ASSERT_FALSE(p);
  EXPECT_THAT(p.error().message, testing::HasSubstr("12"));
}

}  // namespace
}  // namespace im2fit::body
