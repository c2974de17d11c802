// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "estimate/age.h"
#include "train/population/drawn_people.h"

namespace im2fit {
namespace {

// The groups are those people are drawn from.
TEST(Age, GroupsAreThePopulations) {
  for (const bool woman : {false, true}) {
    const auto groups = body::age_groups(woman);
    ASSERT_EQ(groups.size(), kAgeBandCount);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      EXPECT_EQ(std::string(kAgeBandNames[g]), std::to_string(static_cast<int>(groups[g].age_low)) + "-" +
                                                   std::to_string(static_cast<int>(groups[g].age_high)));
      EXPECT_EQ(age_band_of(static_cast<float>(groups[g].age_low + 0.5)), g);
      EXPECT_EQ(age_band_of(static_cast<float>(groups[g].age_high - 0.5)), g);
    }
  }
}

}  // namespace
}  // namespace im2fit
