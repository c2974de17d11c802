// SPDX-License-Identifier: Apache-2.0
// The decision that a figure is a person, by the joints' ensemble spread. Models written by hand: one whose runs
// agree everywhere, one whose runs never do.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "perception/observe/observe.h"
#include "tests/perception/joints_board.h"
#include "tests/perception/joints_model_builder.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::Capsule;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::profile_at;
using room_test::render;
using room_test::room_at_320;
using room_test::Scene;

struct Model {
  // `leaf` mm and six: right in the view, left in its mirror image.
  explicit Model(std::int8_t leaf) : bytes(test::constant_model(0, 0, 0, leaf).bytes()) {
    auto parsed = JointModel::parse(bytes, "model");
    EXPECT_TRUE(parsed);
    model.emplace(std::move(*parsed));
  }
  std::vector<std::byte> bytes;
  std::optional<JointModel> model;
};

class PersonScore : public testing::Test {
 protected:
  Detection show(PersonDetector& sensor, const Scene& s) {
    mask_.assign(static_cast<std::size_t>(s.width * s.height), 7);
    const auto picture = render(s, kKinectNoise, ++seed_);
    return sensor.sense(picture.view(), s.intrinsics(), MaskImage(mask_.data(), s.width, s.height));
  }
  bool mask_empty() const {
    return std::all_of(mask_.begin(), mask_.end(), [](std::uint8_t m) { return m == 0; });
  }
  std::vector<std::uint8_t> mask_;
  std::uint64_t seed_ = 0;
};

// The builder's table: 0.75 up to 500 mm of spread in eleven bins, 0.25 beyond in one; 0.708 on the mean.
TEST_F(PersonScore, IsTheMeanConfidenceByTheUsualOne) {
  const Model agreed(0), apart(100);
  const test::Board board;
  JointTracker sure(*agreed.model), torn(*apart.model);
  board.track(sure);
  board.track(torn);
  constexpr double kUsual = (11 * 0.75 + 0.25) / 12;
  EXPECT_NEAR(sure.person_score(), 0.75 / kUsual, 1e-3);
  EXPECT_NEAR(torn.person_score(), 0.25 / kUsual, 1e-3);
}

TEST_F(PersonScore, WhatTheModelCannotAgreeOnIsNoPerson) {
  const Model agreed(0), apart(100);
  Scene s = room_at_320();
  add(s, person_at(0, 2700, 1));
  PersonDetector sure(s.width, s.height, *agreed.model), torn(s.width, s.height, *apart.model);
  EXPECT_TRUE(show(sure, s).person.found);
  EXPECT_FALSE(mask_empty());
  for (int frame = 0; frame < 20; ++frame) {
    const Detection none = show(torn, s);
    EXPECT_FALSE(none.person.found);
    EXPECT_EQ(none.guidance, static_cast<GuidanceSet>(Guidance::no_person));
    EXPECT_EQ(none.user_count, 0);
    EXPECT_TRUE(mask_empty());
  }
}

TEST_F(PersonScore, TheSelectedUserIsNotRejected) {
  const Model apart(100);
  Scene s = room_at_320();
  add(s, person_at(0, 2700, 1));
  PersonDetector torn(s.width, s.height, *apart.model);
  Segmenter ids(s.width, s.height);
  PersonTracker people;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(s.width * s.height));
  const auto picture = render(s, kKinectNoise, 1);
  const Person person = ids.run(picture.view(), s.intrinsics(), people, MaskImage(mask.data(), s.width, s.height));
  ASSERT_TRUE(person.found);
  torn.people().select(person.id);  // both count from the same number
  EXPECT_TRUE(show(torn, s).person.found);
}

TEST_F(PersonScore, ARejectedUserIsPassedOverForAnother) {
  Scene s = room_at_320();
  add(s, person_at(-500, 2400, 1));
  add(s, person_at(500, 3300, 2));
  Segmenter segmenter(s.width, s.height);
  PersonTracker people;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(s.width * s.height));
  std::uint64_t seed = 0;
  const auto run = [&] {
    const auto picture = render(s, kKinectNoise, ++seed);
    return segmenter.run(picture.view(), s.intrinsics(), people, MaskImage(mask.data(), s.width, s.height));
  };
  const Person near = run();
  ASSERT_TRUE(near.found);
  ASSERT_EQ(people.users().size(), 2U);
  people.reject(near.id);
  const Person other = run();
  EXPECT_TRUE(other.found);
  EXPECT_NE(other.id, near.id);
  EXPECT_FALSE(has(other.guidance, Guidance::several_people)) << "furniture disturbs no measurement";
  people.reject(other.id);
  EXPECT_EQ(run().id, near.id) << "of two rejected ones the nearer";
  people.accept(near.id);
  people.accept(other.id);
  EXPECT_TRUE(has(run().guidance, Guidance::several_people));
}

TEST_F(PersonScore, ACandidateIsFoundByTheJointsInSixFrames) {
  const Model agreed(0), apart(100);
  Scene s = room_at_320();
  add(s, profile_at(0, 2600));
  PersonDetector sure(s.width, s.height, *agreed.model), torn(s.width, s.height, *apart.model);
  int first = -1;
  for (int frame = 0; frame < 12; ++frame) {
    const Detection seen = show(sure, s);
    if (seen.person.found && first < 0) first = frame;
    if (first < 0) continue;
    EXPECT_TRUE(seen.person.found) << "frame " << frame << ": accepted once, accepted for good";
    if (frame == first) continue;
    ASSERT_EQ(seen.user_count, 1);
    EXPECT_TRUE(seen.users[0].confirmed);
  }
  EXPECT_GE(first, 5) << "six frames decide more than one";
  EXPECT_LE(first, 7);
  for (int frame = 0; frame < 20; ++frame) EXPECT_FALSE(show(torn, s).person.found);
}

// Masked backgrounds, black carpets and glossy tiles show no floor: the second chance does without one.
TEST_F(PersonScore, ACandidateNeedsNoFloor) {
  const Model agreed(0), apart(100);
  for (const float wall_z : {0.0F, 4800.0F}) {
    Scene s = room_at_320();
    s.floor = false;
    s.wall_z = wall_z;
    add(s, profile_at(0, 2600));
    PersonDetector sure(s.width, s.height, *agreed.model), torn(s.width, s.height, *apart.model);
    int first = -1;
    for (int frame = 0; frame < 12; ++frame) {
      const Detection seen = show(sure, s);
      EXPECT_FALSE(seen.person.floor.known);
      if (seen.person.found && first < 0) first = frame;
      EXPECT_EQ(seen.person.found, first >= 0) << frame;
    }
    EXPECT_GE(first, 5) << "six frames decide more than one";
    EXPECT_LE(first, 7);
    for (int frame = 0; frame < 20; ++frame) EXPECT_FALSE(show(torn, s).person.found);
  }
}

// A hand before the hip, or a hem, hides where the legs join the trunk: they are a surface of their own.
TEST_F(PersonScore, ABodySplitFromItsLegsIsFoundWhole) {
  const Model agreed(0), apart(100);
  Scene s = room_at_320();
  add(s, profile_at(0, 2500));
  for (Capsule& part : s.capsules)
    if (part.a.y <= 910) part.a.z += 160, part.b.z += 160;  // 90 mm is one surface at that distance
  PersonDetector sure(s.width, s.height, *agreed.model), torn(s.width, s.height, *apart.model);
  int first = -1;
  for (int frame = 0; frame < 16; ++frame) {
    const Detection seen = show(sure, s);
    if (seen.person.found && first < 0) first = frame;
    EXPECT_EQ(seen.person.found, first >= 0) << frame;
    if (!seen.person.found) continue;
    const auto picture = render(s, 0, 1);
    double both = 0, either = 0;
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      both += mask_[i] != 0 && picture.owner[i] == 1 ? 1 : 0;
      either += mask_[i] != 0 || picture.owner[i] == 1 ? 1 : 0;
    }
    EXPECT_GT(both / either, 0.85) << frame;
  }
  EXPECT_GE(first, 5);
  EXPECT_LE(first, 12);
  for (int frame = 0; frame < 30; ++frame) EXPECT_FALSE(show(torn, s).person.found);
}

TEST_F(PersonScore, AnObjectOnABoxIsNoSplitBody) {
  const Model agreed(0);
  Scene s = room_at_320();
  add(s, {{{0, 1150, 2600}, {0, 1500, 2600}, 130, 1}});  // as round as a trunk
  s.boxes.push_back({{-160, 0, 2560}, {160, 1000, 2900}});
  PersonDetector sure(s.width, s.height, *agreed.model);
  for (int frame = 0; frame < 20; ++frame) EXPECT_FALSE(show(sure, s).person.found) << frame;
}

TEST_F(PersonScore, APersonsShapeIsLikelierThanFurnitures) {
  Scene s = room_at_320();
  add(s, person_at(0, 2700, 1));
  Segmenter segmenter(s.width, s.height);
  PersonTracker people;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(s.width * s.height));
  const auto picture = render(s, kKinectNoise, 1);
  const Person person =
      segmenter.run(picture.view(), s.intrinsics(), people, MaskImage(mask.data(), s.width, s.height));
  ASSERT_TRUE(person.found);
  EXPECT_GT(people.shape_odds(person.id), 1.0F);
  EXPECT_EQ(people.shape_odds(person.id + 1), 0.0F) << "of an unknown id";
}

}  // namespace
}  // namespace im2fit
