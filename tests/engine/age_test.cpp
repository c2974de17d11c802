// SPDX-License-Identifier: Apache-2.0
#include "estimate/age.h"

#include <gtest/gtest.h>

#include <vector>

namespace im2fit {
namespace {

TEST(Age, HundredPeopleOfOneToAHundredYears) {
  std::vector<float> ages;
  for (int i = 0; i < 101; ++i) ages.push_back(static_cast<float>(i * 37 % 101));  // every age once, shuffled
  const AgeAnswer age = age_among(ages);
  EXPECT_FLOAT_EQ(age.years.value, 50);
  EXPECT_FLOAT_EQ(age.years.low, 2.5F);
  EXPECT_FLOAT_EQ(age.years.high, 97.5F);
  EXPECT_NEAR(age.bands[0], 25.0 / 101, 1e-5);
  EXPECT_NEAR(age.bands[1], 20.0 / 101, 1e-5);
  EXPECT_NEAR(age.bands[2], 20.0 / 101, 1e-5);
  EXPECT_NEAR(age.bands[3], 36.0 / 101, 1e-5);
}

TEST(Age, OneAndNone) {
  std::vector<float> one = {30};
  const AgeAnswer age = age_among(one);
  EXPECT_EQ(age.years.low, 30);
  EXPECT_EQ(age.years.high, 30);
  EXPECT_EQ(age.bands[1], 1);
  EXPECT_EQ(age_among({}).years.value, 0);
}

}  // namespace
}  // namespace im2fit
