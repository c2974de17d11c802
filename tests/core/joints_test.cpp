// SPDX-License-Identifier: Apache-2.0
#include "core/joints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace im2fit {
namespace {

TEST(Skeleton, ParentsComeBeforeTheirChildrenAndEachJointOnce) {
  std::array<bool, kJointCount> seen{};
  EXPECT_EQ(parent_of(kJointOrder[0]), kJointOrder[0]) << "the root is its own parent";
  for (const Joint joint : kJointOrder) {
    EXPECT_FALSE(seen[joint_index(joint)]);
    EXPECT_TRUE(joint == kJointOrder[0] || seen[joint_index(parent_of(joint))]);
    seen[joint_index(joint)] = true;
  }
  EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](bool s) { return s; }));
}

// Against OpenNI's names: L and R exchange, the rest stays.
TEST(Skeleton, MirrorsByName) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto joint = static_cast<Joint>(j);
    std::string name(kJointNames[j]);
    EXPECT_EQ(is_left(joint), name[0] == 'L');
    EXPECT_EQ(is_right(joint), name[0] == 'R');
    if (name[0] == 'L' || name[0] == 'R') name[0] = name[0] == 'L' ? 'R' : 'L';
    EXPECT_EQ(kJointNames[joint_index(mirror_of(joint))], name);
    EXPECT_EQ(mirror_of(parent_of(joint)), parent_of(mirror_of(joint))) << "the tree is symmetric";
  }
}

}  // namespace
}  // namespace im2fit
