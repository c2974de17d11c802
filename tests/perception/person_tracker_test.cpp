// SPDX-License-Identifier: Apache-2.0
// Accepted, rejected, target and held people, with the joints' evidence written by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/segment/person_tracker_limits.h"
#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using namespace person_tracker_limits;
using room_test::add;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::profile_at;
using room_test::render;
using room_test::room_at_320;
using room_test::Scene;

constexpr JointEvidence kSure = {1.0F, 3.0F, true};
constexpr JointEvidence kPerhaps = {0.5F, 0.5F, true};  // a person's odds, but not at first sight
constexpr JointEvidence kUnsure = {0.5F, -1.5F, true};  // too little, yet not hopeless
constexpr JointEvidence kHopeless = {0.1F, -6.0F, true};

class PersonTracking : public testing::Test {
 protected:
  Person run(const Scene& s) {
    const auto picture = render(s, kKinectNoise, ++seed_);
    return segmenter_.run(picture.view(), s.intrinsics(), people_, MaskImage(mask_.data(), s.width, s.height));
  }
  bool confirmed(int id) const {
    for (const User& user : people_.users())
      if (user.id == id) return user.confirmed;
    return false;
  }
  // Shows the scene until the target user is judged `frames` times. Returns how many of these found a person.
  int accepted_frames(const Scene& s, const JointEvidence& evidence, int frames) {
    int yes = 0;
    for (int i = 0; i < frames; ++i) {
      const Person person = run(s);
      EXPECT_TRUE(person.found) << i;
      yes += people_.judge(person.id, evidence) ? 1 : 0;
    }
    return yes;
  }

  Segmenter segmenter_{320, 240};
  PersonTracker people_;
  std::vector<std::uint8_t> mask_ = std::vector<std::uint8_t>(320 * 240);
  std::uint64_t seed_ = 0;
};

TEST_F(PersonTracking, AConfirmedUserIsAcceptedAtOnceByGoodJoints) {
  Scene s = room_at_320();
  add(s, person_at(0, 2700, 1));
  const Person person = run(s);
  ASSERT_TRUE(person.found);
  EXPECT_FALSE(people_.accepted(person.id));
  EXPECT_TRUE(people_.judge(person.id, kSure));
  EXPECT_TRUE(people_.accepted(person.id));
  EXPECT_TRUE(people_.judge(person.id, kHopeless)) << "accepted once, accepted for good";
}

TEST_F(PersonTracking, ACandidateIsAcceptedAfterSixFrames) {
  Scene s = room_at_320();
  add(s, profile_at(0, 2600));
  for (int i = 0; i < 2; ++i) ASSERT_FALSE(confirmed(run(s).id));
  EXPECT_EQ(accepted_frames(s, kPerhaps, kOddsFrames - 1), 0);
  const Person person = run(s);
  EXPECT_TRUE(people_.judge(person.id, kPerhaps));
  EXPECT_TRUE(people_.accepted(person.id));
  run(s);
  EXPECT_TRUE(confirmed(person.id)) << "by its joints";
}

TEST_F(PersonTracking, WithoutAFloorMoreIsAsked) {
  Scene s = room_at_320();
  add(s, profile_at(0, 2600));
  EXPECT_EQ(accepted_frames(s, {0.5F, 0.9F, false}, 3 * kOddsFrames), 0);
  EXPECT_EQ(accepted_frames(s, {0.5F, 9.0F, false}, 3), 3);
}

// Of two candidates the nearer.
TEST_F(PersonTracking, ACandidateStaysSelectableUntilRejected) {
  Scene s = room_at_320();
  add(s, profile_at(0, 2600));
  int id = 0;
  for (int i = 0; i < kLongFrames; ++i) {
    const Person person = run(s);
    ASSERT_TRUE(person.found) << i;
    if (i == 0) id = person.id;
    EXPECT_EQ(person.id, id);
    EXPECT_FALSE(people_.judge(id, kUnsure)) << i;
  }
  Scene with_another = s;
  add(with_another, profile_at(600, 3600));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(run(with_another).id, id) << "nearer, and not rejected yet";
  EXPECT_FALSE(people_.judge(id, kUnsure));
  const Person other = run(with_another);
  EXPECT_NE(other.id, id) << "rejected: the next one's turn";
}

TEST_F(PersonTracking, AHopelessCandidateIsRejectedSooner) {
  Scene s = room_at_320();
  add(s, profile_at(0, 2600));
  add(s, profile_at(600, 3600));
  const int id = run(s).id;
  for (int i = 0; i < kHopelessFrames; ++i) {
    EXPECT_EQ(run(s).id, id) << i;
    people_.judge(id, kHopeless);
  }
  EXPECT_NE(run(s).id, id);
}

TEST_F(PersonTracking, ARejectionSticks) {
  Scene s = room_at_320();
  add(s, person_at(-500, 2400, 1));
  add(s, person_at(500, 3300, 2));
  const int near = run(s).id;
  EXPECT_FALSE(people_.judge(near, kHopeless)) << "confirmed by its shape, and rejected by one frame of joints";
  for (int i = 0; i < 20; ++i) {
    const Person other = run(s);
    EXPECT_NE(other.id, near) << i;
    EXPECT_FALSE(has(other.guidance, Guidance::several_people)) << "furniture disturbs no measurement";
  }
  people_.accept(near);
  EXPECT_TRUE(has(run(s).guidance, Guidance::several_people));
}

// A person who turns aside is shaped like one no more, and is not given up for that at once.
TEST_F(PersonTracking, AConfirmedUserTurnedAsideStaysConfirmedForAWhile) {
  Scene s = room_at_320(), aside = room_at_320();
  add(s, person_at(0, 2600));
  add(aside, profile_at(0, 2600));
  const int id = run(s).id;
  ASSERT_TRUE(confirmed(id)) << "a person in the first frame";
  for (int i = 0; i < kConfirmed - kUnconfirmedBelow; ++i) {
    ASSERT_EQ(run(aside).id, id) << i;
    EXPECT_TRUE(confirmed(id)) << i;
  }
  ASSERT_EQ(run(aside).id, id);
  EXPECT_FALSE(confirmed(id)) << "never again in the shape of a person";
}

// Two people about as far away: the choice does not flicker from one to the other.
TEST_F(PersonTracking, WhoIsLookedAtIsKeptUntilAnotherIsClearlyNearer) {
  const auto scene = [](float left_mm, float right_mm) {
    Scene s = room_at_320();
    add(s, person_at(-500, left_mm, 1));
    add(s, person_at(500, right_mm, 2));
    return s;
  };
  const int id = run(scene(2700, 2900)).id;
  ASSERT_NE(id, 0);
  for (const float closer : {50.0F, 100.0F, 150.0F, 200.0F})
    EXPECT_EQ(run(scene(2900, 2900 - closer)).id, id) << closer << " mm nearer";
  run(scene(2900, 2600));
  run(scene(2900, 2500));
  EXPECT_NE(run(scene(2900, 2400)).id, id) << "500 mm nearer";
}

TEST_F(PersonTracking, WhoIsSelectedNeedsNoJudgement) {
  Scene s = room_at_320();
  add(s, person_at(0, 2700, 1));
  const int id = run(s).id;
  people_.select(id);
  EXPECT_TRUE(people_.judge(id, kHopeless));
  people_.select(0);
  EXPECT_FALSE(people_.accepted(id)) << "nothing was learned of it";
}

TEST_F(PersonTracking, ARecordEndsWithItsUser) {
  Scene s = room_at_320();
  add(s, person_at(0, 2700, 1));
  const int id = run(s).id;
  EXPECT_TRUE(people_.judge(id, kSure));
  people_.reset();
  EXPECT_FALSE(people_.accepted(id));
  EXPECT_TRUE(people_.users().empty());
  EXPECT_FALSE(people_.judge(id, kSure)) << "the user is gone";
}

TEST(PersonTrackerHold, FromTheFirstGoodFrameUntilTheUserIsGone) {
  PersonTracker people;
  people.hold(3, false);
  EXPECT_EQ(people.selected(), 0) << "another may still come nearer";
  people.hold(4, true);
  EXPECT_EQ(people.selected(), 4);
  for (int i = 0; i < kAbsentPeriodsMax; ++i) people.hold(0, false);
  EXPECT_EQ(people.selected(), 4) << "a flicker";
  people.hold(4, false);
  for (int i = 0; i < kAbsentPeriodsMax; ++i) people.hold(0, false);
  EXPECT_EQ(people.selected(), 4) << "counted anew";
  people.hold(0, false);
  EXPECT_EQ(people.selected(), 0) << "lost";
}

TEST(PersonTrackerHold, ARequestedUserIsNeverGivenUp) {
  PersonTracker people;
  people.select(7);
  for (int i = 0; i < 100; ++i) people.hold(0, false);
  EXPECT_EQ(people.selected(), 7);
  people.release();
  EXPECT_EQ(people.selected(), 7);
  people.reset();
  EXPECT_EQ(people.selected(), 7);
}

TEST(PersonTrackerHold, ReleaseAndResetEndIt) {
  PersonTracker people;
  people.hold(4, true);
  people.release();
  EXPECT_EQ(people.selected(), 0);
  people.hold(4, true);
  people.reset();
  EXPECT_EQ(people.selected(), 0);
}

}  // namespace
}  // namespace im2fit
