// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_detections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "perception/joints/person_votes.h"
#include "tests/perception/joints_model_builder.h"
#include "tests/train/body_fixture.h"

namespace im2fit::lab {
namespace {

constexpr std::size_t kClues = static_cast<std::size_t>(joints::kClueCount);

class TrackerDetections : public WithBody {
 protected:
  VoteExamples collect(int people, int rooms, int threads = 2) const {
    const auto bytes = test::constant_model(0, 0, 0, 0).bytes();
    const auto joint_model = JointModel::parse(bytes, "by hand");
    const std::vector<joints::Anchor> anchors = {{0, 0, 2, 2, 0}, {150, -90, 0, 0, 0}};
    return collect_detections(model(), *joint_model, anchors, {people, rooms, 5, threads}, {});
  }
};

TEST_F(TrackerDetections, PeopleAreFoundAndEachIsFollowedByItsMirrorImage) {
  const VoteExamples seen = collect(14, 0);
  ASSERT_GE(seen.size(), 24U) << "nearly everybody";
  ASSERT_EQ(seen.size() % 2, 0U);
  const auto width = static_cast<std::size_t>(seen.value_count);
  ASSERT_EQ(width, 2 + kClues);
  EXPECT_EQ(seen.values.size(), seen.size() * width);
  EXPECT_EQ(std::count(seen.yes.begin(), seen.yes.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
  int shapeless = 0;
  for (std::size_t i = 0; i < seen.size(); i += 2) {
    const std::int16_t* one = seen.values.data() + i * width + 2;
    EXPECT_EQ(one[2], one[width + 2]) << "person_score";
    if (one[width + 1] == 0)
      ++shapeless;
    else
      EXPECT_EQ(one[1], one[width + 1]) << "shape";
  }
  EXPECT_GE(shapeless, 5);
}

TEST_F(TrackerDetections, EmptyRoomsHoldNoPeople) {
  const VoteExamples seen = collect(0, 64);
  EXPECT_GT(seen.size(), 4U) << "but some things are detected";
  EXPECT_EQ(std::count(seen.yes.begin(), seen.yes.end(), 1), 0);
}

TEST_F(TrackerDetections, ThreadCountDoesNotShow) {
  const VoteExamples one = collect(8, 70, 1), two = collect(8, 70, 2);
  EXPECT_EQ(one.values, two.values);
  EXPECT_EQ(one.yes, two.yes);
}

}  // namespace
}  // namespace im2fit::lab
