// SPDX-License-Identifier: Apache-2.0
// Several people, one after the other and past one another, and what stands still about them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::Capsule;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::Picture;
using room_test::render;
using room_test::Scene;

Scene small_room(float wall_z = 4800) {
  Scene s;
  s.width = 320;
  s.height = 240;
  s.focal = 287.9F;
  s.camera_height = 1100;
  s.pitch_deg = 4;
  s.wall_z = wall_z;
  return s;
}

class SegmentPeople : public testing::Test {
 protected:
  Person run(const Scene& s, float seconds = 1.0F / 30.0F) {
    if (mask_.empty()) mask_.resize(static_cast<std::size_t>(s.width * s.height));
    picture_ = render(s, kKinectNoise, ++seed_);
    return segmenter_.run(picture_.view(), s.intrinsics(), people_, MaskImage(mask_.data(), s.width, s.height),
                          seconds);
  }
  // Id of the user whose crown is nearest to where the figure at (x, z) has it; 0: none within 250 mm.
  int id_at(const Scene& s, float x, float z) const {
    const Vec3f crown = s.to_camera({x, 1700, z - 60});
    float best = 250;
    int id = 0;
    for (const User& user : people_.users()) {
      const Vec3f off = user.head_mm - crown;
      const float away = std::hypot(off.x, off.z);
      if (away >= best) continue;
      best = away;
      id = user.id;
    }
    return id;
  }
  double overlap(int owner) const {
    double both = 0, either = 0;
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      const bool mine = mask_[i] != 0, true_one = picture_.owner[i] == owner;
      both += mine && true_one ? 1 : 0;
      either += mine || true_one ? 1 : 0;
    }
    return either > 0 ? both / either : 0;
  }

  Segmenter segmenter_{320, 240};
  PersonTracker people_;
  Picture picture_;
  std::vector<std::uint8_t> mask_;
  std::uint64_t seed_ = 0;
};

TEST_F(SegmentPeople, IdsStayThroughACrossing) {
  int left = 0, right = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const float share = static_cast<float>(frame) / 59;
    const float x1 = -700 + 1400 * share, x2 = 700 - 1400 * share;
    Scene s = small_room();
    add(s, person_at(x1, 2700, 1));
    add(s, person_at(x2, 3500, 2));
    run(s, 1.0F / 15.0F);
    const int first = id_at(s, x1, 2700), second = id_at(s, x2, 3500);
    if (frame == 0) {
      left = first;
      right = second;
      ASSERT_GE(left, 1);
      ASSERT_GE(right, 1);
      ASSERT_NE(left, right);
    }
    EXPECT_EQ(first, left) << frame;  // never hidden
    if (std::fabs(x1 - x2) > 900) {
      EXPECT_EQ(second, right) << frame;
    }
    for (const User& user : people_.users()) EXPECT_TRUE(user.id == left || user.id == right) << frame;
  }
}

TEST_F(SegmentPeople, WhoReturnsSoonIsTheSameAndWhoReturnsLateIsNot) {
  const Scene empty = small_room();
  Scene s = small_room();
  add(s, person_at(100, 2800));
  Person person;
  for (int i = 0; i < 4; ++i) person = run(s);
  const int id = person.id;
  ASSERT_TRUE(person.found);
  ASSERT_GE(id, 1);
  for (int i = 0; i < 10; ++i) {
    person = run(empty, 0.1F);
    EXPECT_FALSE(person.found);
    EXPECT_EQ(person.id, 0);
    EXPECT_TRUE(people_.users().empty());
  }
  person = run(s);
  ASSERT_TRUE(person.found);
  EXPECT_EQ(person.id, id);
  for (int i = 0; i < 10; ++i) run(empty, 1.0F);
  for (int i = 0; i < 3; ++i) {  // a newcomer is confirmed in the third frame
    EXPECT_FALSE(person.found && i > 0) << i;
    person = run(s);
  }
  ASSERT_TRUE(person.found);
  EXPECT_NE(person.id, id);
}

// The stand reaches over the head and becomes one surface with the person: no other person for that.
TEST_F(SegmentPeople, WhoReturnsBesideACoatStandIsTheSame) {
  Scene empty = small_room();
  add(empty, {{{560, 0, 2800}, {560, 2150, 2800}, 30, 9}});
  Scene before = empty, after = empty;
  add(before, person_at(-400, 2800));
  add(after, person_at(205, 2800));
  int id = 0;
  for (int i = 0; i < 4; ++i) id = run(before).id;
  ASSERT_GE(id, 1);
  for (int i = 0; i < 10; ++i) run(empty, 0.1F);
  for (int i = 0; i < 4; ++i) {
    const Person person = run(after);
    ASSERT_TRUE(person.found) << i;
    EXPECT_EQ(person.id, id) << i;
  }
}

TEST_F(SegmentPeople, ResetForgetsPeopleButNotTheirNumbers) {
  Scene s = small_room();
  add(s, person_at(0, 2800));
  const int before = run(s).id;
  people_.select(before);
  segmenter_.reset();
  people_.reset();
  EXPECT_TRUE(people_.users().empty());
  EXPECT_FALSE(run(s).found) << "the selection stays, for a number that will not be given again";
  people_.select(0);
  const Person after = run(s);
  ASSERT_TRUE(after.found);
  EXPECT_GT(after.id, before);
}

TEST_F(SegmentPeople, TheSelectedOneIsMeasuredAndNoOther) {
  Scene s = small_room();
  add(s, person_at(-400, 2500, 1));
  add(s, person_at(500, 3300, 2));
  run(s);
  EXPECT_GT(overlap(1), 0.93);
  const int near = id_at(s, -400, 2500), far = id_at(s, 500, 3300);
  ASSERT_GE(near, 1);
  ASSERT_GE(far, 1);
  people_.select(far);
  Person person = run(s);
  EXPECT_EQ(person.id, far);
  EXPECT_GT(overlap(2), 0.93);
  Scene alone = small_room();
  add(alone, person_at(-400, 2500, 1));
  person = run(alone);  // the selected one has gone
  EXPECT_FALSE(person.found);
  EXPECT_TRUE(has(person.guidance, Guidance::no_person));
  EXPECT_EQ(person.people_count, 1);
  people_.select(0);
  EXPECT_EQ(run(alone).id, near);
  EXPECT_GT(overlap(1), 0.93);
}

TEST_F(SegmentPeople, UsersAreListedNearestFirstWithTheirBoxes) {
  Scene s = small_room();
  add(s, person_at(500, 3400, 1));
  add(s, person_at(-450, 2600, 2));
  run(s);
  const auto users = people_.users();
  ASSERT_EQ(users.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const int owner = i == 0 ? 2 : 1;
    int u_min = 9999, u_max = -1, v_min = 9999, count = 0;
    for (int v = 0; v < picture_.height; ++v)
      for (int u = 0; u < picture_.width; ++u) {
        if (picture_.owner[static_cast<std::size_t>(v * picture_.width + u)] != owner) continue;
        u_min = std::min(u_min, u);
        u_max = std::max(u_max, u);
        v_min = std::min(v_min, v);
        ++count;
      }
    EXPECT_NEAR(users[i].u_min, u_min, 4);
    EXPECT_NEAR(users[i].u_max, u_max, 4);
    EXPECT_NEAR(users[i].v_min, v_min, 4);
    EXPECT_NEAR(users[i].pixel_count, count, 0.15 * count);
    EXPECT_NEAR(users[i].centroid_mm.z, s.to_camera({0, 950, owner == 2 ? 2600.0F : 3400.0F}).z, 150);
    EXPECT_TRUE(users[i].has_head);
    EXPECT_TRUE(users[i].confirmed);
    EXPECT_FLOAT_EQ(users[i].visible_share, 1);
  }
}

TEST_F(SegmentPeople, APersonFarBehindDoesNotDisturb) {
  Scene s = small_room(6400);
  add(s, person_at(-300, 2400, 1));
  add(s, person_at(700, 4300, 2));
  Person person = run(s);
  ASSERT_TRUE(person.found);
  EXPECT_FALSE(has(person.guidance, Guidance::several_people));
  s.capsules.clear();
  add(s, person_at(-300, 2400, 1));
  add(s, person_at(700, 3100, 2));
  segmenter_.reset();
  people_.reset();
  person = run(s);
  ASSERT_TRUE(person.found);
  EXPECT_EQ(person.people_count, 2);
  EXPECT_TRUE(has(person.guidance, Guidance::several_people));
}

// A chest the calves lean on: one surface with them in a single picture.
Scene with_chest() {
  Scene s = small_room(3600);
  s.boxes = {{{-500, 0, 2700}, {500, 430, 3000}}};
  return s;
}

TEST_F(SegmentPeople, WhatStoodThereBeforeIsNotThePerson) {
  Scene at_once = with_chest();
  add(at_once, person_at(0, 2650));
  run(at_once);
  EXPECT_LT(overlap(1), 0.93);
  segmenter_.reset();
  people_.reset();
  for (int i = 0; i < 75; ++i) EXPECT_FALSE(run(with_chest()).found);
  Scene s = with_chest();
  add(s, person_at(0, 2650));
  Person person;
  for (int i = 0; i < 3; ++i) person = run(s);
  ASSERT_TRUE(person.found);
  EXPECT_GT(overlap(1), 0.95);
}

TEST_F(SegmentPeople, WhoStandsStillDoesNotBecomeTheBackground) {
  Scene s = small_room(3600);
  add(s, person_at(0, 2650));
  for (int i = 0; i < 90; ++i) ASSERT_TRUE(run(s).found) << i;
  EXPECT_GT(overlap(1), 0.95);
}

TEST_F(SegmentPeople, AMovedCameraHasNoBackground) {
  for (int i = 0; i < 75; ++i) run(with_chest());
  for (int i = 0; i < 5; ++i) {
    Scene s = with_chest();
    s.boxes.clear();
    s.camera_height = 1400;
    s.pitch_deg = 9;
    add(s, person_at(100, 2650));
    const Person person = run(s);
    if (i < 2) continue;  // a newcomer is confirmed in the third frame
    ASSERT_TRUE(person.found);
    EXPECT_GT(overlap(1), 0.95) << i;
  }
}

}  // namespace
}  // namespace im2fit
