// SPDX-License-Identifier: Apache-2.0
// People at a room's side walls, bodies split in two components, and others who are hardly seen.
#include <gtest/gtest.h>

#include <cstdint>
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

struct Outcome {
  Person person;
  double overlap = 0;  // of the true mask of `owner` and ours, over both
  std::vector<User> users;
};

// The last of `frames` frames; `chosen` is selected after the first, 0: none.
Outcome observe(const Scene& s, int owner, int chosen = 0, int frames = 3) {
  Outcome seen;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(s.width * s.height));
  Segmenter segmenter(s.width, s.height);
  PersonTracker people;
  Picture p;
  for (int i = 0; i < frames; ++i) {
    p = render(s, kKinectNoise, static_cast<std::uint64_t>(i + 1));
    seen.person = segmenter.run(p.view(), s.intrinsics(), people, MaskImage(mask.data(), s.width, s.height));
    people.select(chosen);
  }
  double both = 0, either = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const bool mine = mask[i] != 0, true_one = p.owner[i] == owner;
    both += mine && true_one ? 1 : 0;
    either += mine || true_one ? 1 : 0;
  }
  seen.overlap = either > 0 ? both / either : 0;
  seen.users.assign(people.users().begin(), people.users().end());
  return seen;
}

Scene room(float wall_z) {
  Scene s;
  s.width = 320;
  s.height = 240;
  s.focal = 287.9F;
  s.camera_height = 1100;
  s.pitch_deg = 4;
  s.wall_z = wall_z;
  return s;
}

// A wall at the side, touched by the hand of a person 420 mm from it.
Scene room_with_side_wall() {
  Scene s = room(4800);
  s.boxes = {{{1100, 0, 300}, {1200, 2800, 4900}}};
  return s;
}

TEST(SegmentCompany, WhoTouchesASideWallIsFound) {
  for (const float z : {3200.0F, 3400.0F, 3600.0F}) {
    Scene s = room_with_side_wall();
    add(s, person_at(690, z));
    const Outcome seen = observe(s, 1);
    ASSERT_TRUE(seen.person.found) << z;
    EXPECT_GT(seen.overlap, 0.93) << z;
  }
}

TEST(SegmentCompany, WhoTouchesASideWallDisturbs) {
  Scene s = room_with_side_wall();
  add(s, person_at(-250, 2500, 1));
  EXPECT_FALSE(has(observe(s, 1).person.guidance, Guidance::several_people));
  add(s, person_at(690, 3300, 2));
  const Outcome seen = observe(s, 1);
  EXPECT_TRUE(has(seen.person.guidance, Guidance::several_people));
  EXPECT_GT(seen.overlap, 0.93);
  ASSERT_EQ(seen.users.size(), 2U);
  EXPECT_GT(observe(s, 2, seen.users[1].id).overlap, 0.93);
}

// A forearm before the belt hides where the trunk joins the legs; a hood is not a head; the feet stand apart.
std::vector<Capsule> astride_at(float x, float z, float foot, int owner = 1) {
  const auto at = [&](float dx, float y, float dz = 0) { return Vec3f{x + dx, y, z + dz}; };
  std::vector<Capsule> c = {
      {at(0, 1620), at(0, 1670), 150, owner},          {at(0, 1450), at(0, 1600), 55, owner},
      {at(-110, 1400), at(110, 1400), 75, owner},      {at(0, 950), at(0, 1350), 115, owner},
      {at(-70, 930), at(-80, 1370), 95, owner},        {at(70, 930), at(80, 1370), 95, owner},
      {at(-170, 1390), at(-270, 1120), 48, owner},     {at(-270, 1120), at(-380, 850), 40, owner},
      {at(170, 1390), at(290, 1120, -120), 48, owner}, {at(290, 1120, -120), at(-260, 940, -240), 48, owner}};
  for (const float s : {-1.0F, 1.0F}) {
    c.push_back({at(s * 85, 900), at(s * (60 + 0.5F * foot), 480), 78, owner});
    c.push_back({at(s * (60 + 0.5F * foot), 480), at(s * foot, 80), 50, owner});
    c.push_back({at(s * foot, 40, 30), at(s * (foot + 20), 35, -150), 35, owner});
  }
  return c;
}

TEST(SegmentCompany, ATrunkOverLegsAstrideIsOnePerson) {
  for (const float foot : {250.0F, 320.0F, 380.0F}) {
    Scene s = room(4200);
    add(s, astride_at(100, 2600, foot));
    const Outcome seen = observe(s, 1);
    ASSERT_TRUE(seen.person.found) << foot;
    EXPECT_GT(seen.overlap, 0.9) << foot;
  }
}

// Of the other one, behind, both forearms leave the legs alone: shaped like a person's, and no person by the rules.
// As much of a chest of drawers is neither.
TEST(SegmentCompany, AnUnconfirmedUserShapedLikeAPersonDisturbs) {
  Scene s = room(4800);
  add(s, person_at(-300, 2500, 1));
  Scene furnished = s;
  furnished.boxes = {{{420, 0, 3100}, {880, 1010, 3400}}, {{520, 1010, 3150}, {780, 1300, 3350}}};
  EXPECT_FALSE(has(observe(furnished, 1).person.guidance, Guidance::several_people));
  add(s, astride_at(650, 2900, 380, 2));
  const float x = 650, z = 2900;
  s.capsules.push_back({{x - 270, 1380, z - 120}, {x + 120, 1530, z - 190}, 60, 2});
  const Outcome seen = observe(s, 1);
  EXPECT_TRUE(has(seen.person.guidance, Guidance::several_people));
  EXPECT_GT(seen.overlap, 0.93);
  ASSERT_EQ(seen.users.size(), 2U);
  EXPECT_FALSE(seen.users[1].confirmed);
}

}  // namespace
}  // namespace im2fit
