// SPDX-License-Identifier: Apache-2.0
// Who is measured of several: in a region, by id, and beside figures that never move. What a wall and cloth without
// depth do.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "perception/segment/segment.h"
#include "perception/segment/still_watch.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::Picture;
using room_test::render;
using room_test::room_at_320;
using room_test::Scene;

constexpr float kLeftX = -450, kRightX = 450, kNearZ = 2500, kFarZ = 2700;

Scene two_people(float left_sway_mm = 0, float right_sway_mm = 0) {
  Scene s = room_at_320();
  add(s, person_at(kLeftX, kNearZ + left_sway_mm, 1));
  add(s, person_at(kRightX, kFarZ + right_sway_mm, 2));
  return s;
}

class WhoIsLeftOut : public testing::Test {
 protected:
  Person run(const Scene& s) {
    mask_.resize(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height));
    if (!segmenter_) segmenter_.emplace(s.width, s.height);
    picture_ = render(s, kKinectNoise, ++seed_);
    if (spoil_) spoil_(picture_);
    return segmenter_->run(picture_.view(), s.intrinsics(), people_, MaskImage(mask_.data(), s.width, s.height));
  }
  const User& user_at(float x) const {
    const auto users = people_.users();
    const User* best = &users[0];
    for (const User& user : users)
      if (std::fabs(user.centroid_mm.x - x) < std::fabs(best->centroid_mm.x - x)) best = &user;
    return *best;
  }
  // Four seconds in which both sway by so much, at 0.4 Hz.
  Person sway(float left_mm, float right_mm) {
    Person last;
    for (int i = 0; i < 120; ++i) {
      const float wave = std::sin(2.5F * static_cast<float>(i) / 30.0F);
      last = run(two_people(left_mm * wave, right_mm * wave));
    }
    return last;
  }

  PersonTracker people_;
  std::optional<Segmenter> segmenter_;
  std::vector<std::uint8_t> mask_;
  Picture picture_;
  std::uint64_t seed_ = 0;
  void (*spoil_)(Picture&) = nullptr;
};

TEST_F(WhoIsLeftOut, InARegionOneOfTwoIsMeasured) {
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(has(run(two_people()).guidance, Guidance::several_people));
  people_.set_region(FloorRegion{100, 2000, 900, 3500});
  const Person person = run(two_people());
  ASSERT_TRUE(person.found);
  EXPECT_GT(person.centroid_mm.x, 0) << "the farther one, as only that one is within";
  EXPECT_FALSE(has(person.guidance, Guidance::several_people));
  EXPECT_EQ(user_at(kLeftX).left_out, LeftOut::outside);
  EXPECT_EQ(user_at(kRightX).left_out, LeftOut::no);
  // The camera looks down: distances are along the floor.
  people_.set_region(FloorRegion{100, kFarZ - 250, 900, kFarZ + 100});
  EXPECT_TRUE(run(two_people()).found);
  people_.set_region(FloorRegion{100, 3000, 900, 3500});
  const Person nobody = run(two_people());
  EXPECT_FALSE(nobody.found);
  EXPECT_TRUE(has(nobody.guidance, Guidance::no_person));
  people_.set_region(std::nullopt);
  EXPECT_TRUE(has(run(two_people()).guidance, Guidance::several_people));
}

TEST_F(WhoIsLeftOut, WhoIsSelectedIsNotDisturbedByOthersBeside) {
  for (int i = 0; i < 3; ++i) run(two_people());
  people_.select(user_at(kRightX).id);
  const Person person = run(two_people());
  ASSERT_TRUE(person.found);
  EXPECT_GT(person.centroid_mm.x, 0);
  EXPECT_FALSE(has(person.guidance, Guidance::several_people));
}

TEST_F(WhoIsLeftOut, WhoIsSelectedIsDisturbedByOneWhoStandsBefore) {
  for (int i = 0; i < 3; ++i) run(two_people());
  people_.select(user_at(kRightX).id);
  Scene hidden = room_at_320();
  add(hidden, person_at(kRightX, kFarZ, 2));
  add(hidden, person_at(150, 1900, 1));
  Person person;
  for (int i = 0; i < 4; ++i) person = run(hidden);
  EXPECT_TRUE(!person.found || has(person.guidance, Guidance::several_people));
}

TEST_F(WhoIsLeftOut, AStillFigureBesideOneWhoSwaysIsLeftOut) {
  const Person person = sway(0, 5);
  ASSERT_TRUE(person.found);
  EXPECT_GT(person.centroid_mm.x, 0) << "the one who sways, though farther";
  EXPECT_FALSE(has(person.guidance, Guidance::several_people));
  EXPECT_EQ(user_at(kLeftX).left_out, LeftOut::still);
  // Until it moves.
  EXPECT_TRUE(has(sway(5, 5).guidance, Guidance::several_people));
  EXPECT_EQ(user_at(kLeftX).left_out, LeftOut::no);
}

TEST_F(WhoIsLeftOut, AMannequinThatStoodAloneHoldsNoSession) {
  Scene alone = room_at_320();
  add(alone, person_at(kLeftX, kNearZ, 1));
  for (int i = 0; i < 120; ++i) run(alone);
  people_.hold(user_at(kLeftX).id, true);
  for (int i = 0; i < 120; ++i) run(alone);
  sway(0, 5);
  EXPECT_EQ(user_at(kLeftX).left_out, LeftOut::still);
  EXPECT_EQ(user_at(kRightX).left_out, LeftOut::no);
}

TEST_F(WhoIsLeftOut, WhoHoldsTheSessionMayStandStillBesideOneWhoFidgets) {
  const auto alone = [&](float sway_mm) {
    Scene s = room_at_320();
    add(s, person_at(kLeftX, kNearZ + sway_mm, 1));
    return run(s);
  };
  for (int i = 0; i < 3; ++i) alone(0);
  people_.hold(user_at(kLeftX).id, true);
  // Who was seen to sway is a person, and may stand as still as a mannequin from then on.
  for (int i = 0; i < 120; ++i) alone(4 * std::sin(2.5F * static_cast<float>(i) / 30.0F));
  sway(0, 0);
  const Person person = sway(0, 5);
  ASSERT_TRUE(person.found);
  EXPECT_LT(person.centroid_mm.x, 0);
  EXPECT_EQ(user_at(kLeftX).left_out, LeftOut::no);
}

TEST_F(WhoIsLeftOut, TwoWhoSwayAndTwoWhoDoNotAreSeveral) {
  EXPECT_TRUE(has(sway(3, 5).guidance, Guidance::several_people));
  WhoIsLeftOut::people_.reset();
  segmenter_->reset();
  EXPECT_TRUE(has(sway(0, 0).guidance, Guidance::several_people)) << "a picture, over and over";
}

TEST_F(WhoIsLeftOut, AStillFigureIsMeasuredWhenSelected) {
  sway(0, 5);
  people_.select(user_at(kLeftX).id);
  const Person person = run(two_people());
  ASSERT_TRUE(person.found);
  EXPECT_LT(person.centroid_mm.x, 0);
  EXPECT_FALSE(has(person.guidance, Guidance::several_people));
}

// Walls 420 mm beside and 500 mm behind: a hand is at the left one.
TEST_F(WhoIsLeftOut, WhoTouchesACabinsWallIsFound) {
  Scene s;
  s.camera_height = 1100;
  s.boxes = {
      {{-520, 0, 300}, {-420, 2800, 3100}}, {{600, 0, 300}, {700, 2800, 3100}}, {{-520, 0, 3000}, {700, 2800, 3100}}};
  add(s, person_at(0, 2450, 1));
  Person person;
  for (int i = 0; i < 3; ++i) person = run(s);
  ASSERT_TRUE(person.found);
  EXPECT_FALSE(person.cut_top);
  int own = 0, other = 0;
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    own += mask_[i] != 0 && picture_.owner[i] == 1 ? 1 : 0;
    other += mask_[i] != 0 && picture_.owner[i] != 1 ? 1 : 0;
  }
  EXPECT_LT(other * 30, own);
}

TEST_F(WhoIsLeftOut, LegsWithoutDepthAreNamed) {
  Scene s = room_at_320();
  s.width = 480;
  s.height = 640;
  s.focal = 575.8F;
  add(s, person_at(0, 2400, 1));
  EXPECT_TRUE(run(s).found);
  spoil_ = [](Picture& p) {  // from the hips down
    for (std::size_t i = p.depth.size() / 2; i < p.depth.size(); ++i)
      if (p.owner[i] == 1) p.depth[i] = 0;
  };
  people_.reset();
  segmenter_->reset();
  Person person;
  for (int i = 0; i < 3; ++i) person = run(s);
  EXPECT_FALSE(person.found);
  EXPECT_EQ(person.guidance, static_cast<GuidanceSet>(Guidance::depth_missing));
  // Outside the region nobody is asked for anything.
  people_.set_region(FloorRegion{1000, 1000, 2000, 3000});
  EXPECT_EQ(run(s).guidance, static_cast<GuidanceSet>(Guidance::no_person));
  people_.set_region(std::nullopt);
  EXPECT_EQ(run(s).guidance, static_cast<GuidanceSet>(Guidance::depth_missing));
  // A bust on a wall: below is the wall.
  spoil_ = [](Picture& p) {
    for (std::size_t i = p.depth.size() / 2; i < p.depth.size(); ++i)
      if (p.owner[i] == 1) p.depth[i] = 4600;
  };
  people_.reset();
  segmenter_->reset();
  for (int i = 0; i < 3; ++i) person = run(s);
  EXPECT_FALSE(has(person.guidance, Guidance::depth_missing));
}

TEST(StillWatch, KnowsTheSpreadOfTheLastSeconds) {
  segment::StillWatch watch;
  EXPECT_FALSE(watch.watched_long());
  const auto stand = [&](float x, float depth, int frames) {
    for (int i = 0; i < frames; ++i) {
      watch.place_mm({x, 0, 2000});
      watch.add(depth, 1.0F / 30);
    }
  };
  stand(0, 2000, 90);
  EXPECT_TRUE(watch.watched_long());
  EXPECT_FLOAT_EQ(watch.spread_mm(), 0);
  stand(0, 2004, 30);
  EXPECT_FLOAT_EQ(watch.spread_mm(), 4);
  stand(0, 2004, 240);
  EXPECT_FLOAT_EQ(watch.spread_mm(), 0) << "older than six seconds";
  stand(200, 2004, 30);
  EXPECT_FALSE(watch.watched_long()) << "it walked: watched anew";
}

}  // namespace
}  // namespace im2fit
